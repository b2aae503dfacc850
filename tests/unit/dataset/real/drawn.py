"""Frames of a drawn sensor: dots over colours that run across the picture, and a ball that presses a bright disk."""

import csv
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.uint8]
ROWS, COLUMNS = 60, 80
MILLISECOND = Fraction(1, 1000)


def untouched(number: int = 0) -> Image:
    """RGB: red from the left, blue from the right, green from above, dark dots, and a little noise."""
    rows, columns = np.mgrid[0:ROWS, 0:COLUMNS]
    image = np.stack([180 - 1.6 * columns, 150 - 1.5 * rows, 40 + 1.0 * columns], 2)
    dots = ((rows % 12 - 6) ** 2 + (columns % 12 - 6) ** 2) < 8
    image[dots] *= 0.2
    noise = np.random.default_rng(number).normal(0, 0.4, image.shape)
    return np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)


def pressed(force_n: float, number: int = 0) -> Image:
    """The same with a disk that grows with the force."""
    image = untouched(number)
    if force_n > 0.05:
        rows, columns = np.mgrid[0:ROWS, 0:COLUMNS]
        image[(rows - 30) ** 2 + (columns - 40) ** 2 < 100 * force_n] = (235, 140, 60)
    return image


def save(path: Path, image: Image) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), image[..., ::-1])


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def public_set(folder: Path, forces_n: Sequence[float]) -> Path:
    """A folder of images beside `image_name,fx,fy,fz`, as public sets have it, and a description of it."""
    rows = []
    for number, force in enumerate(forces_n):
        save(folder / "images" / f"{number:04d}.png", pressed(force, number))
        rows.append({"image_name": f"{number:04d}.png", "fx": 0.1 * force, "fy": 0, "fz": force})
    write_csv(folder / "labels.csv", rows)
    return describe(folder, 'frames = "images"', 'labels = "labels.csv"', "untouched_below_n = 0.02")


def describe(folder: Path, *recording: str, top: Sequence[str] = ()) -> Path:
    """A description with one recording."""
    path = folder / "mine.toml"
    lines = ["schema_version = 1", *top, "[[recordings]]", *recording, ""]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def video(path: Path, images: Sequence[Image], times_s: Sequence[float]) -> None:
    """A lossless video whose frames have these times."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("ffv1", rate=1000)
        stream.width, stream.height, stream.pix_fmt = images[0].shape[1], images[0].shape[0], "bgr0"
        stream.time_base = MILLISECOND
        for image, at in zip(images, times_s, strict=True):
            frame = av.VideoFrame.from_ndarray(image, format="rgb24").reformat(format="bgr0")
            frame.pts, frame.time_base = round(1000 * at), MILLISECOND
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
