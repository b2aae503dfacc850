"""Takes: what one simulated episode shows before the camera, kept on disk so that it is rendered once.

Noise and exposure come afterwards, so that other sensor noise and other seeds of it cost no rendering. A take's file is
named after a hash of everything that decides its content; it appears whole or not at all, so a run that was cut off
goes on where it stopped.
"""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

import magicsim
from magicsim.config.named_files import config_digest
from magicsim.folder import result_file
from magicsim.scenes.scene import SceneConfig

TAKE_FORMAT = 2
"""Raised with every change of the file's content."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Take:
    """An episode before the camera. All arrays but `radiance` and `room` have one entry a frame, references first."""

    radiance: npt.NDArray[np.float32]
    """States that look different, shape (states, rows, columns, 3); the untouched sensor first."""
    room: npt.NDArray[np.float32]
    """What the room's light makes of the untouched image, shape (rows, columns, 3); empty where nothing asks for it."""
    state: npt.NDArray[np.int32]
    """Which of them a frame shows."""
    is_reference: npt.NDArray[np.bool_]
    gap_mm: npt.NDArray[np.float64]
    """NaN without an object."""
    force_n: npt.NDArray[np.float64]
    """Size of the contact force [N]."""
    flashlight: npt.NDArray[np.bool_]


def take_key(scene: SceneConfig) -> str:
    """Hash of everything that decides a take: the scene, the version of the program, and the files that it names."""
    content = {
        "format": TAKE_FORMAT,
        "version": magicsim.__version__,
        "scene": scene.model_dump(mode="json"),
    }
    return config_digest(content)[:24]


def read_take(path: Path) -> Take:
    """Reads what `write_take` wrote."""
    with path.open("rb") as file, np.load(file, allow_pickle=False) as content:
        return Take(**{name: content[name] for name in Take.__slots__})


def write_take(path: Path, take: Take) -> None:
    """Writes a take; the file appears whole or not at all.

    Raises:
        OutputError: It cannot be written.
    """
    arrays = {name: getattr(take, name) for name in Take.__slots__}
    with result_file(path) as partial, partial.open("wb") as file:
        np.savez(file, **arrays)
        file.flush()
        os.fsync(file.fileno())
