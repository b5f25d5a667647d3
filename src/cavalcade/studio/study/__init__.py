"""The tab Study: runs, plans and campaigns are looked at and compared."""
