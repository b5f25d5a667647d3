"""The tab Drive: simulated and real robots are driven from the page."""
