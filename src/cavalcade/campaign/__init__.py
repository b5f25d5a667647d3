"""Campaigns: many seeded trials, judged, counted and compared."""
