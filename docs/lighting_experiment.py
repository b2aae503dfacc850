"""The lighting experiment: how contact and room light change the colours of a see-through sensor.

python docs/lighting_experiment.py          # writes docs/lighting-experiment.jpg and .json, a few minutes

Scene `lighting` on its own rig `two-pairs` and on a DIGIT's lights (`digit-rgb`), in the dark and in an office; all
figures are read off 8-bit frames, as the camera gives them.
"""

import json
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from magicsim import load_scene, simulate

Frame = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]
HERE = Path(__file__).parent
RIGS = ("two-pairs", "digit-rgb")
ROOMS = {"dark": "rig.room='dark'", "office": "rig.room='office'"}
EXPOSURE = "rig.camera.exposure_grey=60"
CHANNELS = ("red", "green", "blue")
BORDER = 0.08
"""Part of each side of the image, beside the strips, that evenness leaves out."""
SMOOTH_PX = 10.5
"""Width of a cell, over which evenness does not look [px]."""
AROUND_PX = 15
"""How far around the contact the cells belong to it [px]."""


def filmed(rig: str, room: str) -> tuple[list[Frame], list[Mask]]:
    """Frames of the scene (nothing, light touch, heavy touch) and where they touch."""
    ambient = "rig.ambient=[0.1,0.1,0.1]" if room == "office" else "rig.ambient=[0,0,0]"
    episode = simulate(load_scene("lighting", [f"rig={rig}", ROOMS[room], ambient, EXPOSURE]))
    frames = [frame for frame in episode.frames if not frame.truth.is_reference]
    return [frame.image for frame in frames], [frame.contact_mask for frame in frames]


def unevenness(image: Frame) -> list[float]:
    """Standard deviation over mean of each channel over the image, cells smoothed away."""
    rows, columns, _ = image.shape
    smooth = cv2.GaussianBlur(image.astype(float), (0, 0), SMOOTH_PX)
    inner = smooth[round(BORDER * rows) : -round(BORDER * rows), round(BORDER * columns) : -round(BORDER * columns)]
    return [round(float(inner[..., each].std() / inner[..., each].mean()), 3) for each in range(3)]


def disparity(image: Frame, where: Mask) -> float:
    """Standard deviation across the channels of a pixel over their mean, averaged over pixels."""
    pixels = image[where].astype(float)
    return round(float((pixels.std(axis=1) / np.maximum(pixels.mean(axis=1), 1)).mean()), 3)


def brightening(rest: Frame, touched: Frame, where: Mask) -> dict[str, dict[str, float]]:
    """Mean change of each channel around a contact on its four sides [grey levels]."""
    rows, columns = np.nonzero(where)
    y, x = np.mgrid[: where.shape[0], : where.shape[1]]
    dx, dy = x - columns.mean(), rows.mean() - y
    sides = {
        "-x": (dx < 0) & (abs(dx) > abs(dy)), "+x": (dx > 0) & (abs(dx) > abs(dy)),
        "-y": (dy < 0) & (abs(dy) > abs(dx)), "+y": (dy > 0) & (abs(dy) > abs(dx)),
    }  # fmt: skip
    change = touched.astype(float) - rest
    return {
        name: {side: round(float(change[where & part, each].mean()), 2) for side, part in sides.items()}
        for each, name in enumerate(CHANNELS)
    }


def measured(images: list[Frame], masks: list[Mask]) -> dict[str, Any]:
    """All figures of one rig in one room."""
    size = 2 * AROUND_PX + 1
    around = cv2.dilate(masks[-1].astype(np.uint8), np.ones((size, size), np.uint8)) > 0
    return {
        "unevenness at rest": dict(zip(CHANNELS, unevenness(images[0]), strict=True)),
        "disparity around the contact": {
            name: disparity(image, around) for name, image in zip(("rest", "light", "heavy"), images, strict=True)
        },
        "change around the contact, heavy": brightening(images[0], images[-1], around),
        "share of pixels that brighten, heavy": round(
            float((images[-1].astype(int).sum(2) > images[0].astype(int).sum(2))[around].mean()), 3
        ),
    }


def labelled(image: Frame, text: str) -> Image.Image:
    """A picture with a line of text above it."""
    canvas = Image.new("RGB", (image.shape[1], image.shape[0] + 16), "white")
    canvas.paste(Image.fromarray(image), (0, 16))
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
