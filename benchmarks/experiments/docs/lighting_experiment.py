"""The lighting experiment: how contact and room light change the colours of a see-through sensor.

python benchmarks/experiments/docs/lighting_experiment.py   # its .jpg and .json, a few minutes

Scene `lighting` on its own rig `two-pairs` and on a DIGIT's lights (`digit-rgb`), in the dark and in an office; all
figures are read off 8-bit frames, as the camera gives them; the picture is in a screen's tone curve.
"""

import json
import sys
from pathlib import Path
from typing import Any

from PIL import Image, ImageDraw

from magicsim import load_scene, simulate
from magicsim.notebook.screen import on_screen
from magicsim_experiments.study.lighting.color_measures import (
    CHANNELS,
    Frame,
    Mask,
    around,
    brightening,
    disparity,
    share_brighter,
    unevenness,
)

HERE = Path(__file__).parent
RIGS = ("two-pairs", "digit-rgb")
ROOMS = {"dark": "rig.room='dark'", "office": "rig.room='office'"}
EXPOSURE = "rig.camera.exposure_grey=60"


def filmed(rig: str, room: str) -> tuple[list[Frame], list[Mask]]:
    """Frames of the scene (nothing, light touch, heavy touch) and where they touch."""
    ambient = "rig.ambient=[0.1,0.1,0.1]" if room == "office" else "rig.ambient=[0,0,0]"
    episode = simulate(load_scene("lighting", [f"rig={rig}", ROOMS[room], ambient, EXPOSURE]))
    frames = [frame for frame in episode.frames if not frame.truth.is_reference]
    return [frame.image for frame in frames], [frame.contact_mask for frame in frames]


def measured(images: list[Frame], masks: list[Mask]) -> dict[str, Any]:
    """All figures of one rig in one room."""
    where = around(masks[-1])
    uneven = [round(each, 3) for each in unevenness(images[0])]
    change = brightening(images[0], images[-1], where)
    return {
        "unevenness at rest": dict(zip(CHANNELS, uneven, strict=True)),
        "disparity around the contact": {
            name: round(disparity(image, where), 3)
            for name, image in zip(("rest", "light", "heavy"), images, strict=True)
        },
        "change around the contact, heavy": {
            name: {side: round(value, 2) for side, value in sides.items()} for name, sides in change.items()
        },
        "share of pixels that brighten, heavy": round(share_brighter(images[0], images[-1], where), 3),
    }


def labelled(image: Frame, text: str) -> Image.Image:
    """A picture with a line of text above it."""
    canvas = Image.new("RGB", (image.shape[1], image.shape[0] + 16), "white")
    canvas.paste(Image.fromarray(on_screen(image, gamma=1.0)), (0, 16))
    ImageDraw.Draw(canvas).text((3, 2), text, fill="black")
    return canvas


def main() -> None:
    """Renders, measures, writes."""
    figures: dict[str, Any] = {}
    tiles: list[list[Image.Image]] = []
    for rig in RIGS:
        row: list[Image.Image] = []
        for room in ROOMS:
            images, masks = filmed(rig, room)
            figures[f"{rig}, {room}"] = measured(images, masks)
            row += [
                labelled(image, f"{rig}, {room}: {name}")
                for name, image in zip(("rest", "0.3 mm", "1.2 mm"), images, strict=True)
            ]
        tiles.append(row)
    width, height = tiles[0][0].size
    sheet = Image.new("RGB", (width * len(tiles[0]), height * len(tiles)), "white")
    for down, row in enumerate(tiles):
        for across, tile in enumerate(row):
            sheet.paste(tile, (across * width, down * height))
    sheet.save(HERE / "lighting-experiment.jpg", quality=88, subsampling=0, optimize=True)
    text = json.dumps(figures, indent=1)
    (HERE / "lighting-experiment.json").write_text(text + "\n", encoding="utf-8")
    sys.stdout.write(text + "\n")


if __name__ == "__main__":
    main()
