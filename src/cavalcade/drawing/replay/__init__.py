"""Replays: one HTML file that any browser shows, offline."""
