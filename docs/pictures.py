"""Draws the README's picture: the four states of the default sensor, each beside its change against rest.

python docs/pictures.py                    # writes docs/four-states.jpg, about two minutes
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from magicsim import load_scene, simulate
from magicsim.notebook.screen import STRONGER

STATES = {"rest": "at rest", "near": "ball 1 mm away", "pressed": "pressed 1 mm", "flashlight": "flashlight"}
QUALITY = ("render.samples=16", "render.particles=300000")
STRIP_PX, SPACE_PX, ACROSS = 24, 16, 2


def picture(name: str) -> npt.NDArray[np.uint8]:
    """The frame of one scene preset beside its change, shape (rows, columns, 3)."""
    episode = simulate(load_scene(name, QUALITY))
    return episode.on_screen(episode.scored[:1])[0]


def main() -> None:
    """Renders, labels and joins the four states."""
    frames = [picture(name) for name in STATES]
    rows, columns, _ = frames[0].shape
    size = ACROSS * (columns + SPACE_PX) - SPACE_PX, len(frames) // ACROSS * (rows + STRIP_PX)
    sheet = Image.new("RGB", size, "white")
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(14)
    for number, (frame, label) in enumerate(zip(frames, STATES.values(), strict=True)):
        left, top = number % ACROSS * (columns + SPACE_PX), number // ACROSS * (rows + STRIP_PX)
        sheet.paste(Image.fromarray(frame), (left, top + STRIP_PX))
        draw.text((left + 2, top + 4), f"{label}, and {STRONGER} times its change", fill="black", font=font)
    sheet.save(Path(__file__).with_name("four-states.jpg"), quality=92)


if __name__ == "__main__":
    main()
