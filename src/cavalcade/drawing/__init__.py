"""Figures and replays of runs and plans."""
