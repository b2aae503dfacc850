"""Frames per second of the detectors on one core, and the ratio to the published equations in plain NumPy.

    python benchmarks/detectors.py [--frames 200] [--out FILE.json]

Frames of 320 rows by 240 columns: a grid with noise, frames that brighten, darken and shift. Both implementations judge
the same frames in turn in one process with one thread, so that their ratio holds on a noisy machine; the median of the
times counts, and what the two find is compared before anything is timed. The profile `calibrated` has a row of its own:
what it has beyond the published equations costs time, and plain NumPy has none of it.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import cv2
import numpy as np
from laboratory import plain_detectors as plain

from magicsim.detectors import (
    DetectorProfile,
    Frame,
    GraspState,
    detect,
    fuse,
    load_profile,
    step_grasp,
)
from magicsim.detectors.combined import followed
from magicsim.detectors.features import brightening_correlation, brightening_entropy, filter_channels, grid_areas

ROWS, COLUMNS, REFERENCES, SCENES = 320, 240, 30, 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """Median time of one step over one frame."""

    method: str
    milliseconds: float
    frames_per_second: float


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectorSpeed:
    """What the benchmark found."""

    rows: int
    columns: int
    frames: int
    threads: int
    chain: list[Timing]
    """Algorithms 2 and 3 and the combined verdict: package, package as a stream with the grasp machine, package
    with the profile `calibrated`, plain NumPy."""
    steps: list[Timing]
    """The package's single steps."""
    fuse_milliseconds: float
    """Algorithm 1 from 30 frames."""
    ratio_to_plain: float
    """How many times as many frames as plain NumPy."""
    largest_difference: dict[str, float]
    """Between both implementations, over all frames."""


def sensor_frames() -> tuple[list[Frame], list[Frame]]:
    """References and frames to judge."""
    rng = np.random.default_rng(0)
    rows, columns = np.indices((ROWS, COLUMNS))
    grid = np.where((rows % 10 < 4) | (columns % 10 < 4), 15.0, 80.0)[..., None] * [1.0, 0.8, 0.6]
    spot = np.exp(-((rows - 150) ** 2 + (columns - 110) ** 2) / 4000)[..., None]

    def noisy(image: np.ndarray) -> Frame:
        return np.clip(np.rint(image + rng.normal(0, 1, image.shape)), 0, 255).astype(np.uint8)

    references = [noisy(grid) for _ in range(REFERENCES)]
    frames = [noisy(grid + number * spot * [20, 8, 14]) for number in range(SCENES)]
    return references, frames


def median_milliseconds(tasks: dict[str, Callable[[Frame], object]], frames: list[Frame], count: int) -> list[Timing]:
    """Median time of each task, the tasks taking turns frame by frame."""
    seconds: dict[str, list[float]] = {name: [] for name in tasks}
    for number in range(count):
        frame = frames[number % len(frames)]
        for name, task in tasks.items():
            start = time.perf_counter()
            task(frame)
            seconds[name].append(time.perf_counter() - start)
    medians = {name: statistics.median(each) for name, each in seconds.items()}
    return [
        Timing(method=name, milliseconds=round(1e3 * each, 4), frames_per_second=round(1 / each, 1))
        for name, each in medians.items()
    ]


def measure(count: int) -> DetectorSpeed:
    """Times both implementations on `count` frames each."""
    cv2.setNumThreads(1)
    profile, options = DetectorProfile(), plain.PlainOptions()
    references, frames = sensor_frames()
    start = time.perf_counter()
    fused = fuse(references, profile)
    fuse_seconds = time.perf_counter() - start
    plainly = plain.fuse(references, options)
    found = [detect(frame, fused, profile) for frame in frames]
    expected = [plain.detect(frame, plainly, options) for frame in frames]
    differences = {
        name: max(abs(getattr(one, name) - other[k]) for one, other in zip(found, expected, strict=True))
        for k, name in enumerate(("entropy", "correlation", "similarity"))
    }

    references_now, machine = fused, GraspState()

    def stream(frame: Frame) -> None:
        nonlocal references_now, machine
        verdict = detect(frame, references_now, profile)
        references_now = followed(references_now, verdict, profile)
        machine = step_grasp(machine, verdict, profile)

    calibrated = load_profile("calibrated")
    fused_calibrated = fuse(references, calibrated)
    filtered = filter_channels(frames[-1], fused.background)
    chain = median_milliseconds(
        {
            "package": lambda frame: detect(frame, fused, profile),
            "package, stream and grasp": stream,
            "package, calibrated": lambda frame: detect(frame, fused_calibrated, calibrated),
            "plain NumPy": lambda frame: plain.detect(frame, plainly, options),
        },
        frames,
        count,
    )
    return DetectorSpeed(
        rows=ROWS,
        columns=COLUMNS,
        frames=count,
        threads=cv2.getNumThreads(),
        chain=chain,
        steps=median_milliseconds(
            {
                "filter": lambda frame: filter_channels(frame, fused.background),
                "entropy": lambda _: brightening_entropy(filtered),
                "correlation": lambda _: brightening_correlation(filtered),
                "grid areas": lambda frame: grid_areas(frame, fused.grid),
            },
            frames,
            count,
        ),
        fuse_milliseconds=round(1e3 * fuse_seconds, 2),
        ratio_to_plain=round(chain[0].frames_per_second / chain[-1].frames_per_second, 1),
        largest_difference=differences,
    )


def main() -> None:
    """Prints one JSON object, and writes it where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    text = json.dumps(asdict(measure(arguments.frames)), indent=1)
    print(text)
    if arguments.out is not None:
        arguments.out.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
