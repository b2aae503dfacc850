"""The smallest spacing of dots and lines that a frame still shows.

A plate with the pattern and one without are pressed alike. A(f) is the amplitude of the frame's contrast at a spatial
frequency f on the plate's place on the face. The pattern's own amplitude stands out by

    d' = (A_pattern(f) - mean A_plain) / sqrt((var A_pattern(f) + var A_plain(f)) / 2 + var_f A_plain)

with variances over frames that differ in the camera's noise, and the clutter of the plain plate over frequencies around
f: the grid itself. An ideal observer of two alternatives is right with probability Phi(d' / sqrt 2), 0.92 at d' = 2
(Green and Swets 1966), which counts as told apart.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from magicsim.detectors.frame import Frame
from magicsim.geometry.objects import BoxObject, DotsObject, LinesObject, ObjectConfig
from magicsim.scenes.film import pixel_landing_mm
from magicsim.scenes.scene import OutputSettings, SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.scenes.untouched import UntouchedStates
from magicsim.simulation import Sensor, sensor_exposure
from magicsim.scenes.exposure import FloatImage, expose
from magicsim.sweep.bootstrap import interval
from magicsim.sweep.measures import Measured
from magicsim.sweep.quality import Quality
from magicsim.sweep.sensors import SweptSensor, camera_of, render_of

Array = npt.NDArray[np.float64]
Pattern = Literal["dots", "lines"]
PLATE_MM = 5.0
"""Side of the plates."""
LOOKED_AT_MM = 4.0
"""Side of the square of the face on which contrast is measured: less than the plate, whose edges are no pattern."""
TOLD_APART = 2.0
"""Least d'."""
CLUTTER = (0.75, 0.85, 1.15, 1.3)
"""Frequencies around the pattern's, in units of it."""
MARGIN_PX = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateFrames:
    """Frames of one pressed plate on its place of the face."""

    contrast: Array
    """Change of grey level in units of the untouched sensor's mean, without its mean, shape (draws, pixels, 3)."""
    places_mm: Array
    """Where the pixels look on the face, shape (pixels, 2) [mm]."""
    picture: Frame
    """The first frame, whole."""


def plate(pattern: Pattern | None, spacing_mm: float) -> ObjectConfig:
    """A plate with dots or lines half as wide as their spacing, or without."""
    if pattern == "dots":
        return DotsObject(kind="dots", radius_mm=spacing_mm / 4, spacing_mm=spacing_mm, size_mm=PLATE_MM)
    if pattern == "lines":
        return LinesObject(kind="lines", width_mm=spacing_mm / 2, spacing_mm=spacing_mm, size_mm=PLATE_MM)
    return BoxObject(kind="box", size_mm=(PLATE_MM, PLATE_MM, 2.0))


def press_plate(
    sensor: SweptSensor, thing: ObjectConfig, quality: Quality, *, seed: int, untouched: UntouchedStates
) -> PlateFrames:
    """Presses a plate on the axis and looks at its place.

    Raises:
        MagicsimError: The design, the deformation or an image is not valid.
    """
    scene = plate_scene(sensor, thing, quality, seed=seed)
    simulated = Sensor(scene, untouched=untouched)
    state = timeline(scene)[0]
    deformation = simulated.deform(state, simulated.rest)
    rest, pressed = simulated.radiance(UNTOUCHED, simulated.rest), simulated.radiance(state, deformation)
    camera, exposure = scene.rig.camera, sensor_exposure(simulated, rest)

    def frames(image: FloatImage, first: int) -> npt.NDArray[np.float64]:
        return np.stack(
            [expose(image, exposure, camera, seed=seed, frame=first + draw) for draw in range(quality.draws)]
        ).astype(float)

    shown, reference = frames(pressed, 0), frames(rest, quality.draws).mean(0)
    landing = pixel_landing_mm(scene.design, scene.rig)
    inside = np.abs(landing).max(2) <= LOOKED_AT_MM / 2
    contrast = ((shown - reference) / reference[inside].mean(0))[:, inside]
    return PlateFrames(
        contrast=contrast - contrast.mean(1, keepdims=True),
        places_mm=landing[inside],
        picture=shown[0].astype(np.uint8),
    )


def plate_scene(sensor: SweptSensor, thing: ObjectConfig, quality: Quality, *, seed: int) -> SceneConfig:
    """A scene of one pressed plate, its camera reading out what lies around the plate."""
    camera = camera_of(sensor, quality, scale=quality.texture_scale)
    whole = sensor.rig.model_copy(update={"camera": camera})
    near = np.abs(pixel_landing_mm(sensor.design, whole)).max(2) <= PLATE_MM / 2
    rows, columns = np.flatnonzero(near.any(1)), np.flatnonzero(near.any(0))
    top, left = max(0, rows[0] - MARGIN_PX), max(0, columns[0] - MARGIN_PX)
    bottom, right = min(camera.rows, rows[-1] + 1 + MARGIN_PX), min(camera.columns, columns[-1] + 1 + MARGIN_PX)
    region = (int(left), int(top), int(right - left), int(bottom - top))
    return SceneConfig.model_validate(
        {
            "schema_version": 1,
            "design": sensor.design,
            "rig": sensor.rig.model_copy(update={"camera": camera.model_copy(update={"region_px": region})}),
            "seed": seed,
            "references": 0,
            "object": thing,
            "render": render_of(sensor, quality),
            "output": OutputSettings(**dict.fromkeys(OutputSettings.model_fields, False)),
            "keyframes": [{"frame": 0, "gap_mm": -quality.texture_depth_mm}],
        }
    )


def amplitudes(frames: PlateFrames, pattern: Pattern, frequency_per_mm: float) -> Array:
    """Amplitude of the contrast at a frequency, root mean square over channels, shape (draws,).

    Lines repeat along x; dots along x and y, whose amplitudes are added in squares. A Hann window keeps the square's
    edges from leaking into other frequencies.
    """
    window = np.prod(np.cos(np.pi * frames.places_mm / LOOKED_AT_MM) ** 2, axis=1)
    total = np.zeros(len(frames.contrast))
    for axis in (0, 1) if pattern == "dots" else (0,):
        wave = np.exp(2j * np.pi * frequency_per_mm * frames.places_mm[:, axis]) * window
        found = np.abs(np.einsum("p,dpc->dc", wave, frames.contrast)) * 2 / window.sum()
        total += (found**2).mean(1)
    return np.sqrt(total)


def discriminability(
    with_pattern: PlateFrames, plain: PlateFrames, pattern: Pattern, spacing_mm: float
) -> "Observation":
    """What d' of one spacing is made of."""
    frequency = 1 / spacing_mm
    around = np.stack([amplitudes(plain, pattern, share * frequency) for share in CLUTTER])
    return Observation(
        pattern=amplitudes(with_pattern, pattern, frequency), plain=amplitudes(plain, pattern, frequency), around=around
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Observation:
    """Amplitudes of one spacing."""

    pattern: Array
    """Shape (draws,)."""
    plain: Array
    around: Array
    """Of the plain plate at frequencies around, shape (frequencies, draws)."""

    def d_prime(self, draws: npt.NDArray[np.int64]) -> float:
        """See the module; of some draws."""
        around = np.concatenate([self.plain[None], self.around])[:, draws].mean(1)
        noise = (self.pattern[draws].var() + self.plain[draws].var()) / 2
        return float((self.pattern[draws].mean() - around.mean()) / np.sqrt(noise + around.var(ddof=1)))


def smallest_spacing(spacings_mm: Array, observed: list[Observation], *, seed: int) -> Measured:
    """The spacing at which d' falls to 2, between tested ones by their logarithm.

    Args:
        spacings_mm: Falling, shape (spacings,) [mm].
        observed: One for each.
        seed: Of the bootstrap over frames.
    """

    def crossing(draws: npt.NDArray[np.int64]) -> float:
        return told_apart_to(spacings_mm, np.array([each.d_prime(draws) for each in observed]))

    count = len(observed[0].pattern)
    value = crossing(np.arange(count))
    low, high = interval(crossing, count, seed=seed)
    if value == np.inf:
        note = f"above the largest spacing tried, {spacings_mm[0]:g} mm"
        return Measured(value=None, low=float(spacings_mm[0]), note=note)
    if value <= spacings_mm[-1]:
        return Measured(value=value, high=_finite(high), note="at most: the smallest spacing tried is told apart")
    return Measured(value=value, low=_finite(low), high=_finite(high))


def told_apart_to(spacings_mm: Array, d_prime: Array) -> float:
    """Smallest spacing down to which d' stays at 2 or more [mm]; infinite where the largest is not told apart."""
    missed = np.flatnonzero(d_prime < TOLD_APART)
    if not len(missed):
        return float(spacings_mm[-1])
    first = int(missed[0])
    if first == 0:
        return float("inf")
    share = (d_prime[first - 1] - TOLD_APART) / (d_prime[first - 1] - d_prime[first])
    return float(spacings_mm[first - 1] * (spacings_mm[first] / spacings_mm[first - 1]) ** share)


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
