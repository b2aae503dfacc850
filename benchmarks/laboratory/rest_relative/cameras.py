"""Recordings of a take: a story of its states before a drawn camera, with drift and a step of the exposure.

What an untouched sensor does besides: people move in the room, whose light sways by a part and not everywhere alike,
and a touch leaves a dent that goes back in some frames. Both are assumed.

The renderer's grain (the paths of a touched state are others than those of the untouched one) is no sign of a touch on
a real sensor. Away from the contact a touched state is therefore the untouched one times a smooth ratio.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
import numpy.typing as npt

from laboratory.rest_relative.takes import DrawnTake
from magicsim.arrays import FloatImage, Frame
from magicsim.camera.camera import Camera
from magicsim.camera.effect_settings import H264, Dust, Flicker, Glare, LedDrift, LiveExposure, Mjpeg, Shutter
from magicsim.camera.stream import CameraStream, Instant
from magicsim.evaluation.take import Take
from magicsim.frame_class import FrameClass, classify_frame

SMOOTH_PX, REACH_PX = 6.0, 24.0
"""Standard deviation of the smooth ratio, and how far from the middle of a touch a picture is kept as rendered [px]."""
NEARER_PX = 42
"""Half the side of what a nearer camera sees [px]."""
CLEAR, HELD = 15, 4
"""Frames of each untouched spell, and of every other state."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """Frames of one sensor through one camera."""

    name: str
    type: str
    references: list[Frame]
    frames: list[Frame]
    classes: tuple[FrameClass | None, ...]
    depth_mm: npt.NDArray[np.float64]
    """Minus the gap; NaN without an object."""
    stepped: npt.NDArray[np.bool_]
    """Frames after a step of the exposure."""


def without_grain(take: Take, state: int) -> FloatImage:
    """A state whose difference from the untouched one is smooth, away from where it is largest."""
    rest, image = take.radiance[0], take.radiance[state]
    floor = 1e-3 * float(rest.mean())
    change = (image + floor) / (rest + floor)
    smooth = cv2.GaussianBlur(change, (0, 0), SMOOTH_PX)
    strength = cv2.GaussianBlur(np.abs(np.log(change)).mean(2), (0, 0), SMOOTH_PX)
    rows, columns = np.indices(strength.shape)
    row, column = np.unravel_index(int(strength.argmax()), strength.shape)
    kept = np.exp(-((((rows - row) ** 2 + (columns - column) ** 2) / (2 * REACH_PX**2)) ** 2))[..., None]
    return np.asarray(kept * image + (1 - kept) * ((rest + floor) * smooth - floor), dtype=np.float32)


def film(drawn: DrawnTake, take: Take, number: int, *, is_grainy: bool = False) -> Recording:
    """One camera's recording; `number` draws camera, rate, references, drift and step."""
    random = np.random.default_rng([7701, number, *map(ord, drawn.name)])
    camera, rate = _camera(drawn.scene.rig.camera, random), float(random.choice([10.0, 15.0, 30.0, 60.0]))
    count = int(random.choice([5, 10, 20, 30, 60]))
    step = float(np.exp(random.uniform(-0.3, 0.3))) if random.random() < 0.5 else 1.0
    drift, period = float(random.uniform(0, 0.03)), float(random.uniform(60, 400))
    touched = take.force_n > 0
    looks = {
        frame: take.radiance[state] if is_grainy or not touched[frame] else without_grain(take, state)
        for frame, state in enumerate(take.state.tolist())
    }
    sway, dent = _log(random, 0.005, 0.15), float(random.uniform(0, 0.05))
    waves, beat = random.uniform(-0.05, 0.05, 2), float(random.uniform(20, 200))
    fading, left = float(random.uniform(5, 60)), np.zeros_like(take.radiance[0])
    rows, columns = np.indices(left.shape[:2])
    stream = CameraStream.of(camera, take.radiance[0], drawn.scene.lit, room=take.room if take.room.size else None)
    memory, images, classes, depths, stepped = stream.begin(rate), [], [], [], []
    for index, (frame, is_late) in enumerate(_story(take, count)):
        share = (1 + drift * np.sin(2 * np.pi * index / period)) * (step if is_late else 1.0)
        at = Instant(seed=1000 * number + 7, index=index, time_s=index / rate, frames_per_second=rate)
        look = looks[frame]
        if touched[frame]:
            left = dent * (look - take.radiance[0])
        else:
            left = left * np.float32(np.exp(-1 / fading))
            look = look + left
        if take.room.size:
            wave = np.sin(2 * np.pi * index / beat + waves[0] * columns + waves[1] * rows)[..., None]
            look = look + (sway * wave).astype(np.float32) * np.minimum(take.room, look)
        image, memory = stream.take(np.maximum(look, 0) * np.float32(share), memory, at)
        images.append(image)
        gap = float(take.gap_mm[frame])
        depths.append(-gap)
        stepped.append(is_late and step != 1.0)
        classes.append(
            classify_frame(gap_mm=None if np.isnan(gap) else gap, force_n=float(take.force_n[frame]),
                           light_on=bool(take.flashlight[frame]))
        )  # fmt: skip
    return Recording(
        name=f"{drawn.name}/{number}", type=drawn.type, references=images[:count], frames=images[count:],
        classes=tuple(classes[count:]), depth_mm=np.array(depths[count:]), stepped=np.array(stepped[count:]),
    )  # fmt: skip


def _story(take: Take, references: int) -> Iterator[tuple[int, bool]]:
    """Frames of the take in order, and whether the exposure has stepped.

    Rest, all states of the first place, rest, a step, rest, states of the second place, rest, light, rest.
    """
    untouched, lit = 1, np.flatnonzero(take.flashlight).tolist()
    others = [each for each in range(2, len(take.state)) if each not in lit]
    cut = len(others) - (2 if np.all(take.gap_mm[others] < 0) else 3)
    for spell, is_late in (
        ([untouched] * (references + CLEAR), False),
        ([each for each in others[:cut] for _ in range(HELD)], False),
        ([untouched] * CLEAR, False),
        ([untouched] * CLEAR, True),
        ([each for each in others[cut:] for _ in range(HELD)], True),
        ([untouched] * CLEAR, True),
        ([each for each in lit for _ in range(HELD)], True),
        ([untouched] * CLEAR, True),
    ):
        yield from ((each, is_late) for each in spell)


def _log(random: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def _camera(camera: Camera, random: np.random.Generator) -> Camera:
    """A webcam at small size."""
    codecs = (None, Mjpeg(kind="mjpeg", quality=int(random.integers(75, 96))),
              H264(kind="h264", crf=int(random.integers(16, 25))))  # fmt: skip
    return camera.model_copy(
        update={
            "exposure_grey": float(random.uniform(40, 120)),
            "blur_px": float(random.uniform(0.5, 1.0)),
            "gamma": float(random.choice([1.0, 1.0, 1.8, 2.2])),
            "full_well_e": _log(random, 6e3, 2.5e5),
            "read_noise_e": _log(random, 4, 60),
            "vibration_px": _log(random, 0.002, 0.03),
            "pattern_seed": int(random.integers(1 << 30)),
            "live": LiveExposure() if random.random() < 1 / 3 else None,
            "led_drift": LedDrift(share=_log(random, 0.001, 0.01), time_s=_log(random, 5, 60)),
            "glare": Glare(share=float(random.uniform(0.01, 0.08)), radius_px=float(random.uniform(10, 30))),
            "dust": Dust(specks=int(random.integers(0, 20)), radius_px=2.0, opacity=float(random.uniform(0.05, 0.4))),
            "flicker": Flicker(depth=float(random.uniform(0.02, 0.1))),
            "shutter": Shutter(exposure_ms=10.0, row_us=float(random.uniform(20, 60))),
            "compression": codecs[int(random.integers(3))],
        }
    )


def nearer(recording: Recording) -> Recording:
    """The same frames where the deepest touch is, `NEARER_PX` to each side: a smaller sensor, or a larger object."""
    deep = np.nanmax(recording.depth_mm)
    rest = np.mean(recording.references, axis=0)
    pressed = np.mean([recording.frames[each] for each in np.flatnonzero(recording.depth_mm == deep)], axis=0)
    change = cv2.GaussianBlur(np.abs(pressed - rest).sum(2), (0, 0), SMOOTH_PX)
    row, column = (int(each) for each in np.unravel_index(int(change.argmax()), change.shape))
    part = np.s_[max(0, row - NEARER_PX) : row + NEARER_PX, max(0, column - NEARER_PX) : column + NEARER_PX]
    return replace(
        recording,
        name=f"{recording.name} nearer",
        references=[np.ascontiguousarray(each[part]) for each in recording.references],
        frames=[np.ascontiguousarray(each[part]) for each in recording.frames],
    )
