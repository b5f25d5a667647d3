"""The replay: one HTML file that shows a run or a plan in any browser, offline.

`write_replay` of `page` is the way in; `data` gathers what the page needs, `assets/` is the page.
Its scripts share one scope: `assets/app.js` comes last and says what is drawn.
"""
