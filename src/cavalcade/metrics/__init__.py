"""Metrics of runs and plans: distances, errors, lower bounds, and the summary that holds them."""
