"""What tests of physics share."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture(scope="session")
def hold():
    """Let a simulator pass so many steps with joints held by springs, standing unless said."""

    def hold(simulator, steps, after=None, wanted=None, stiffness=100.0, damping=3.0):
        standing = np.array([robot.standing for robot in simulator.descriptions])
        angles = standing if wanted is None else wanted
        for _ in range(steps):
            away = angles - simulator.qpos[:, 7:]
            simulator.step(stiffness * away - damping * simulator.qvel[:, 6:])
            if after is not None:
                after()

    return hold
