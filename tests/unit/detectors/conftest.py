"""A small synthetic sensor: dark grid lines on a bright ground, and what happens to it."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from magicsim.detectors import DetectorProfile, Frame, References, fuse

ROWS, COLUMNS = 48, 36
SHAPE = (ROWS, COLUMNS, 3)


def grid_frame(shift: int = 0) -> Frame:
    """Dark lines of level 10 every 6 px on a ground of level 80; `shift` moves them, as a press would."""
    frame = np.full(SHAPE, 80, dtype=np.uint8)
    rows, columns = np.indices((ROWS, COLUMNS))
    frame[((rows + shift) % 6 < 3) | ((columns + shift) % 6 < 2)] = 10
    return frame


def near_frame(seed: int = 0) -> Frame:
    """Each channel brightens in other places."""
    added = np.random.default_rng(seed).integers(0, 20, SHAPE)
    return (grid_frame() + added).astype(np.uint8)


def light_frame(seed: int = 0) -> Frame:
    """All channels brighten alike."""
    added = np.random.default_rng(seed).integers(0, 150, (ROWS, COLUMNS, 1))
    return (grid_frame() + added).astype(np.uint8)


@pytest.fixture
def profile() -> DetectorProfile:
    return DetectorProfile(reference_count=6, grid_blur_px=0)


@pytest.fixture
def references(profile: DetectorProfile) -> References:
    return fuse([grid_frame()] * 6, profile)


@pytest.fixture
def save() -> Callable[[Path, np.ndarray], Path]:
    """Write an RGB image to a file."""

    def write(path: Path, image: np.ndarray) -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        assert cv2.imwrite(str(path), image[..., ::-1] if image.ndim == 3 else image)
        return path

    return write


@pytest.fixture
def write_video() -> Callable[..., Path]:
    """Write RGB images to a video file; the default codec is lossless."""

    def write(path: Path, images: list[np.ndarray], codec: str = "FFV1") -> Path:
        rows, columns, _ = images[0].shape
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*codec), 15, (columns, rows))
        assert writer.isOpened()
        for image in images:
            writer.write(np.ascontiguousarray(image[..., ::-1]))
        writer.release()
        return path

    return write
