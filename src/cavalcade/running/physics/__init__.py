"""Runs in physics: what is recorded of them, drawn, and summed up."""
