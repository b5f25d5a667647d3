"""Without MuJoCo: everything else works, and one line says what to install."""

from __future__ import annotations

import subprocess
import sys

import pytest

WITHOUT = """
import sys
sys.modules["mujoco"] = None  # what is None cannot be imported
import cavalcade
from cavalcade.errors import InputError
from cavalcade.fleet.mujoco import PhysicsGround, PhysicsSettings, TeamSimulator
from cavalcade.robots import robot_model
ground, settings = PhysicsGround(), PhysicsSettings()
try:
    TeamSimulator([robot_model("go1")], [(0.0, 0.0, 0.0)], ground, settings)
except InputError as error:
    print(error)
"""


def test_one_line_says_what_to_install():
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT], capture_output=True, text=True, check=True
    )
    assert done.stdout == ("physics: MuJoCo is not installed: pip install 'cavalcade[physics]'\n")


def test_importing_the_package_does_not_load_the_engine():
    pytest.importorskip("mujoco")
    code = "import sys, cavalcade.fleet.mujoco; print('mujoco' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
