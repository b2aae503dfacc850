"""Lifts an object of unknown weight: grip a little, rise, and grip harder as soon as the skin slides.

python docs/examples/lift_without_slip.py      # needs the extra `robot` (gymnasium)
"""

import sys
from typing import Any

import numpy as np

from magicsim.robot import GraspLift

FIRST_GRIP_MM = 0.4
"""Depth of the first grip [mm]."""
SLIDING_SHARE = 0.6
"""Share of the contact that slides at which the grip is tightened."""


def lift(env: GraspLift, *, seed: int, options: dict[str, float] | None = None) -> dict[str, Any]:
    """Plays one episode by the truth of slip; a learner would read it off the images.

    Args:
        env: The environment.
        seed: Of the episode.
        options: See `GraspLift.reset`.

    Returns:
        The last step's info, with `reward` summed over the episode and `steps`.
    """
    _, info = env.reset(seed=seed, options=options)
    total, steps, is_over = 0.0, 0, False
    while not is_over:
        is_touching = -info["gap_mm"] >= FIRST_GRIP_MM - 1e-6
        closing = 0.0 if is_touching and info["slip_share"] < SLIDING_SHARE else 0.5
        rising = 0.6 if is_touching and info["object_mm"] < env.target_mm else 0.0
        _, reward, is_done, is_late, info = env.step(np.array([closing, rising], np.float32))
        total, steps, is_over = total + reward, steps + 1, is_done or is_late
    return {**info, "reward": total, "steps": steps}


def main() -> None:
    """Plays three episodes and writes a line for each."""
    env = GraspLift()
    for seed in range(3):
        end = lift(env, seed=seed)
        sys.stdout.write(
            f"{end['weight_n']:.2f} N: {'lifted' if end['is_success'] else 'failed'} after {end['steps']} steps, "
            f"grip {end['normal_n']:.2f} N, reward {end['reward']:.2f}\n"
        )
    env.close()


if __name__ == "__main__":
    main()
