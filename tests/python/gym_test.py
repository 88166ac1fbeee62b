"""A cell as an environment of Gymnasium."""
import pathlib
import warnings

import gymnasium
import numpy as np
import pytest
import takt
from gymnasium.utils.env_checker import check_env

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOUCH = ROOT / "scenarios/touch.json"


def made(**options):
    return takt.gym.make(TOUCH, observe=["tool", "q", "dq", "force:wrist"], seconds=0.5, **options)


def test_gymnasium_finds_nothing():
    env = made()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*render_modes.*")
        warnings.filterwarnings("ignore", message=".*not wrapped.*")
        warnings.filterwarnings("ignore", message=".*symmetric.*")
        check_env(env, skip_render_check=True)
    env.close()


def episode(env, seed, actions):
    seen, info = env.reset(seed=seed)
    rows = [seen]
    for action in actions:
        seen, _, over, late, info = env.step(action)
        rows.append(seen)
        if over or late:
            break
    return np.array(rows), info


def test_equal_seeds_and_actions_give_equal_digests():
    env = made()
    actions = np.random.default_rng(1).uniform(-1, 1, (25, 6))
    (one, first), (two, second), (_, other) = episode(env, 4, actions), episode(env, 4, actions), episode(env, 5, actions)
    assert first["digest"] and first["digest"] == second["digest"] != other["digest"]
    assert (one == two).all() and len(one) == 26


def test_the_tool_goes_the_way_of_the_actions():
    for act, step in (("cartesian_offset", 0.002), ("twist", 0.1 * 0.02)):
        env = made(act=act)
        rows, _ = episode(env, 1, [[1, 0, 0, 0, 0, 0]] * 20)
        tool = rows[:, env.unwrapped.layout["tool"]]
        # It gets up to speed first.
        assert 0.6 * 20 * step < tool[-1, 0] - tool[0, 0] < 20 * step
        assert np.abs(tool[-1, 1:3] - tool[0, 1:3]).max() < 2e-3
        env.close()


def test_reward_and_success_end_an_episode():
    def sunk(cell, seen):
        return seen[2]

    start = []
    env = made(start=lambda cell: start.append(cell.arm().tool[2, 3]), reward=lambda cell, seen: -float(seen[2]),
               success=lambda cell, seen: sunk(cell, seen) < start[-1] - 0.01)
    env.reset(seed=2)
    for k in range(30):
        seen, value, over, late, info = env.step([0, 0, -1, 0, 0, 0])
        assert value == pytest.approx(-seen[2])
        if over or late:
            break
    assert over and not late and info["success"] and k < 15
    with pytest.raises(takt.UsageError):
        env.step(np.zeros(6))


def refused(**options):
    with pytest.raises(takt.Error) as caught:
        takt.gym.make(TOUCH, **options)
    return caught.value.code


def test_wrong_use():
    assert refused(observe=["tol"]) == "unknown-name"
    assert refused(observe=["force:nobody"]) == "unknown-name"
    assert refused(act="torque") == "unknown-name"
    assert refused(cycles=0) == "out-of-range"
    assert refused(seeds=3) == "unknown-key"
    assert isinstance(made().action_space, gymnasium.spaces.Box)
