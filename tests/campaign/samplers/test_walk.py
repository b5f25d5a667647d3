"""Draws of robots under commands."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from cavalcade.campaign.samplers import SAMPLERS, DataFolder
from cavalcade.campaign.suite import parse_suite
from cavalcade.campaign.trial import check_worlds, trials_of
from cavalcade.errors import InputError, ScenarioError
from cavalcade.scenario import build_world, parse_scenario

DATA = DataFolder(None)
WALKS = {
    "steady": {"kind": "steady", "velocity": [0.8, 0, 0]},
    "random": {"kind": "random"},
    "four": {"kind": "random", "robots": 4, "models": ["go1", "go2"]},
    "push": {"kind": "push", "impulse": 20},
    "rough": {"kind": "rough"},
    "blocks": {"kind": "blocks"},
    "stairs": {"kind": "stairs"},
    "down": {"kind": "stairs", "height": -0.08},
    "gap": {"kind": "gap", "width": 0.4},
    "step": {"kind": "step"},
}


def sampler(name, **more):
    said = {"sampler": "walk", **WALKS[name], **more}
    return SAMPLERS[said["sampler"]].model_validate(said)


def scenario(instance):
    said = {
        **instance.scenario,
        "execution": {**instance.scenario["execution"], "backend": "mujoco"},
    }
    return parse_scenario(said)


@pytest.mark.parametrize("name", WALKS)
def test_laws_of_every_kind(name):
    found = sampler(name)
    assert not found.individual_goals
    assert found.limit(DATA) is None
    seen = set()
    for seed in range(4):
        instance = found.sample(seed, DATA)
        again = found.sample(seed, DATA).scenario
        assert json.dumps(instance.scenario) == json.dumps(again)
        assert instance.feasible
        made = scenario(instance)
        assert made.seed == seed
        assert made.task.length <= made.execution.timeout
        world = build_world(made)
        assert not world.map.occupied.any()
        seen.add(json.dumps(instance.scenario["robots"]))
    assert len(seen) == 4


@pytest.mark.parametrize("name", ["random", "four"])
def test_random_commands_keep_their_limits_and_come_often(name):
    made = scenario(sampler(name).sample(3, DATA))
    assert made.task.length == 20.0
    for robot in range(len(made.robots)):
        own = [one for one in made.task.commands if one.robot == robot]
        velocities = np.array([one.velocity for one in own])
        assert (np.abs(velocities) <= [0.5, 0.2, 1.0]).all()
        assert (np.abs(velocities).max(axis=0) > [0.25, 0.1, 0.5]).all()
        holds = np.diff([one.at for one in own])
        assert ((holds > 0.299) & (holds < 2.001)).all()


def test_ways_of_several_robots_stay_apart():
    """Followed to the letter, step by step, unlike the sampler's own reckoning."""
    for seed in range(3):
        made = scenario(sampler("four").sample(seed, DATA))
        size = made.world.empty.size
        low = made.world.empty.origin
        poses = np.array(made.starts)
        velocity = np.zeros_like(poses)
        due = list(made.task.commands)
        for step in range(2000):
            while due and due[0].at <= 0.01 * step:
                one = due.pop(0)
                velocity[one.robot] = one.velocity
            c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
            poses[:, 0] += 0.01 * (c * velocity[:, 0] - s * velocity[:, 1])
            poses[:, 1] += 0.01 * (s * velocity[:, 0] + c * velocity[:, 1])
            poses[:, 2] += 0.01 * velocity[:, 2]
            apart = np.hypot(*(poses[:, None, :2] - poses[None, :, :2]).T)
            assert (apart + 9.0 * np.eye(4)).min() > 1.8
            assert (poses[:, :2] > np.array(low) + 1.8).all()
            assert (poses[:, :2] < np.array(low) + np.array(size) - 1.8).all()


def test_pushes_have_their_impulse_and_a_quarter_stands():
    standing, sides = 0, []
    for seed in range(40):
        made = scenario(sampler("push").sample(seed, DATA))
        (event,) = made.execution.events
        assert math.hypot(*event.push.impulse) == pytest.approx(20.0, abs=1e-3)
        assert event.push.duration == 0.1
        assert 2.3 <= event.at <= 2.8
        standing += made.task.commands[0].velocity == (0.0, 0.0, 0.0)
        sides.append(math.atan2(*event.push.impulse[::-1]))
    assert standing == 10
    assert np.histogram(sides, 4, (-math.pi, math.pi))[0].min() > 3


def test_one_at_a_time_on_terrain():
    with pytest.raises(InputError, match="one robot at a time"):
        sampler("stairs", robots=2).sample(0, DATA)


def suite(**group):
    return parse_suite(
        {
            "version": 1,
            "suite": "walks",
            "backend": "mujoco",
            "worlds": [{"name": "a", "seeds": 1, "sampler": "walk", **group}],
        }
    )


def test_a_suite_says_who_moves_the_robots():
    made = suite(kind="random")
    assert parse_suite(made.to_dict()) == made
    (trial,) = trials_of(made, (), DATA)
    found = trial.scenario(trial.instance())
    assert found.execution.backend == "mujoco"
    assert found.planner.method == "commands"
    check_worlds(made, (), DATA)


def test_other_variants_follow_no_commands():
    with pytest.raises(ScenarioError, match=r"worlds\[0\].*expected cavalcade"):
        check_worlds(suite(kind="random", variants=["published"]), (), DATA)
