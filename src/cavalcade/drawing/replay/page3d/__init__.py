"""Pages that show things in three dimensions in any browser, offline: what all of them share.

A page is one HTML file that draws with WebGL and loads nothing from anywhere. `assets/` has the
scripts; their top-level names are common to all scripts of a page, which are joined in one scope.
A page's own scripts give `bounds`, `eyesOn`, `end`, `drawAll` and whatever else those ask for.
"""
