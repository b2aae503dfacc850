"""Stable-Baselines3 on the environment, for 64 steps: `nox -s learner`."""

import numpy as np
import pytest

from .conftest import TINY

pytestmark = pytest.mark.slow
LARGE_ENOUGH = ["rig.camera.columns=48", "rig.camera.rows=64"]
"""For the learner's own network of convolutions, which takes 36 pixels and more."""
gymnasium = pytest.importorskip("gymnasium")
learners = pytest.importorskip("stable_baselines3", reason="nox -s learner installs it")


@pytest.mark.filterwarnings("ignore")  # of its own dependencies
def test_64_steps_of_ppo_change_the_policy():
    from magicsim.robot.environment import GraspLift

    env = GraspLift(overrides=[*TINY, *LARGE_ENOUGH], max_steps=8, told=lambda _: None)
    learner = learners.PPO("MultiInputPolicy", env, n_steps=32, batch_size=16, n_epochs=1, seed=1, device="cpu")
    before = learner.policy.parameters_to_vector()
    learner.learn(64)
    after = learner.policy.parameters_to_vector()
    env.close()
    assert np.isfinite(after).all()
    assert not np.array_equal(before, after)
