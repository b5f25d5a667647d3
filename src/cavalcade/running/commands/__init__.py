"""Runs whose robots follow commands instead of a planner."""
