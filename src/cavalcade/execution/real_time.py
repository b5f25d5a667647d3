"""Makes a process fit for control cycles that robots wait for."""

import gc
import sys

SWITCH = 0.0005
"""A thread that computes in Python lets others run after so long, s; Python's own is ten times as
long, and a cycle may have to wait for it again and again."""


def prepare_process() -> None:
    """Keep pauses of Python's own out of what follows; call it once everything is compiled.

    A full collection looks at all objects that imports and compilation made, some 75 ms long; they
    stay, so that nobody need look at them again.
    """
    gc.collect()
    gc.freeze()
    sys.setswitchinterval(SWITCH)
