"""Figures of runs in physics."""
