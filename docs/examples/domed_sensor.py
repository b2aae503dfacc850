"""A sensor with a dome and a coat: from readings of a caliper and a photo to labelled frames.

python docs/examples/domed_sensor.py         # writes docs/domed-sensor.jpg
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from magicsim import load_scene, simulate
from magicsim.notebook.screen import from_srgb
from magicsim.simulation.episode import Episode

SCENE = Path(__file__).parent / "domed-sensor" / "press.toml"
SHOWN = (3, 5)
"""Scored frames in the picture: pressed, slid."""


def radius_mm(width_mm: float, fall_mm: float) -> float:
    """Radius of a circle that falls by so much from the middle of a chord of that width to its ends [mm].

    R^2 = (w / 2)^2 + (R - f)^2.
    """
    return ((width_mm / 2) ** 2 + fall_mm**2) / (2 * fall_mm)


def reflectance(coat: Sequence[float], paper: Sequence[float], paper_reflectance: float = 0.85) -> list[float]:
    """Linear reflectance of a coat, from its colour and that of white paper in the same light of one photo.

    Args:
        coat: Mean red, green and blue of the coat, 0 to 255, as an image viewer tells them (sRGB).
        paper: The same of the paper; not white in the photo, or it says nothing.
        paper_reflectance: Of office paper, 0.8 to 0.9.
    """
    light, white = (from_srgb(np.array(color) / 255) for color in (coat, paper))
    return (paper_reflectance * light / white).round(2).tolist()


def run(settings: Sequence[str] = ()) -> Episode:
    """Simulates the press, with some settings changed."""
    return simulate(load_scene(SCENE, settings))


def main() -> None:
    """Prints what the design needs of the readings, and draws three frames beside their changes."""
    print("radius_x_mm", round(radius_mm(20.0, 1.25), 1), "radius_y_mm", round(radius_mm(26.0, 1.40), 1))
    print("color", reflectance((120, 120, 122), (202, 203, 201)))
    episode = run(["render.samples=48", "render.anchor_samples=384"])
    frames = [episode.references[0], *(episode.scored[number] for number in SHOWN)]
    sheet = Image.fromarray(np.hstack(episode.on_screen(frames)))
    sheet.resize((2 * sheet.width, 2 * sheet.height), Image.Resampling.LANCZOS).save(
        Path(__file__).parents[1] / "domed-sensor.jpg", quality=90
    )


if __name__ == "__main__":
    main()
