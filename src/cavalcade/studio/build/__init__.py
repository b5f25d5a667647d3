"""The tab Build: a scenario is set up by clicks and fields."""
