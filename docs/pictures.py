"""Draws the README's picture: the four states of the default sensor as its camera sees them.

python docs/pictures.py                    # writes docs/four-states.jpg, about two minutes
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from magicsim.camera.exposure import expose, meter
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.simulation.sensor import Sensor

STATES = {"rest": "at rest", "near": "ball 1 mm away", "pressed": "pressed 1 mm", "flashlight": "flashlight"}
QUALITY = ("render.samples=16", "render.particles=300000")
STRIP_PX = 24


def picture(name: str) -> npt.NDArray[np.uint8]:
    """The camera's frame of one scene preset, shape (rows, columns, 3)."""
    scene = load_scene(name, QUALITY)
    sensor = Sensor.for_scene(scene)
    exposure = meter(sensor.radiance(UNTOUCHED, sensor.rest), scene.rig.camera)
    state = timeline(scene)[0]
    deformation = sensor.deform(state, sensor.rest) if state.can_touch else sensor.rest
    return expose(sensor.radiance(state, deformation), exposure, scene.rig.camera, seed=scene.seed, frame=0)


def main() -> None:
    """Renders, labels and joins the four states."""
    frames = [picture(name) for name in STATES]
    rows, columns, _ = frames[0].shape
    sheet = Image.new("RGB", (len(frames) * (columns + 8) - 8, rows + STRIP_PX), "white")
    draw = ImageDraw.Draw(sheet)
    for number, (frame, label) in enumerate(zip(frames, STATES.values(), strict=True)):
        left = number * (columns + 8)
        sheet.paste(Image.fromarray(frame), (left, STRIP_PX))
        draw.text((left + 4, 6), label, fill="black")
    sheet.save(Path(__file__).with_name("four-states.jpg"), quality=92)


if __name__ == "__main__":
    main()
