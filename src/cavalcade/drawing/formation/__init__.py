"""Figures of a run of a formation."""
