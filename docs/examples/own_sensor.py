"""Your own sensor: another footprint, other LEDs, no grid.

python docs/examples/own_sensor.py         # writes docs/own-sensor.jpg
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from magicsim import load_scene, simulate
from magicsim.simulation.episode import Episode

SCENE = Path(__file__).parent / "own-sensor" / "press.toml"
SHOWN = (0, 3, 5)
"""Scored frames in the picture: near, pressed, slid."""


def run(settings: Sequence[str] = ()) -> Episode:
    """Simulates the sensor, with some settings changed."""
    return simulate(load_scene(SCENE, settings))


def main() -> None:
    """Draws the untouched frame and three others beside their changes, in the quality of the tutorial's picture."""
    episode = run(["render.samples=24", "render.particles=400000", "render.anchor_particles=8000000"])
    pairs = episode.on_screen([episode.references[0], *(episode.scored[number] for number in SHOWN)])
    sheet = Image.fromarray(np.vstack([np.hstack(pairs[:2]), np.hstack(pairs[2:])]))
    sheet.resize((2 * sheet.width, 2 * sheet.height), Image.Resampling.LANCZOS).save(
        Path(__file__).parents[1] / "own-sensor.jpg", quality=90
    )


if __name__ == "__main__":
    main()
