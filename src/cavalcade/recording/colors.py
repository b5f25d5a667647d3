"""The colours that robots have by their slots, in recordings and on live graphs."""

SLOT_COLORS = (
    (0.84, 0.37, 0.00),
    (0.00, 0.45, 0.70),
    (0.00, 0.62, 0.45),
    (0.80, 0.47, 0.65),
    (0.94, 0.89, 0.26),
    (0.34, 0.71, 0.91),
    (0.90, 0.62, 0.00),
)
"""Okabe and Ito's, told apart by nearly everyone; the first is the leader's slot. Red, green, blue
from 0 to 1."""

NO_SLOT = (0.5, 0.5, 0.5)
"""Of robots without one."""
