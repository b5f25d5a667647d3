"""From bodies' motion to feet and torques: footholds, gait, predictive control, leg control.

`LegControl` turns measured states and velocity commands into joint torques; `solve_mpc` is the
predictive control behind it, for a problem of one's own. Neither needs a simulator.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
