"""Constants of nature that planning, control and drawing share."""

GRAVITY = 9.81
"""Acceleration of free fall, m/s²."""
