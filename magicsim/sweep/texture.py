"""The smallest spacing of dots and lines that a frame still shows.

A plate with the pattern and one without are pressed alike, and D is the difference of their frames on the plate's
place in units of the untouched sensor's grey level: what only the pattern makes, the printed grid taken out. P is D's
power at the pattern's spatial frequency along its own axes, P_0 the mean power at that frequency in other directions,
where the pattern has none: noise of camera and rendering, and cells that moved otherwise. For a pattern of known
frequency and phase in Gaussian clutter

    d' = sqrt(2 (P - P_0) / P_0)

(Green and Swets 1966), 0 where P is below P_0. A spacing is told apart at d' >= 2, so P >= 3 P_0, which clutter alone
reaches in about exp(-3) = 5 % of cases.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from magicsim.detectors.frame import Frame
from magicsim.geometry.objects import BoxObject, DotsObject, LinesObject, ObjectConfig
from magicsim.scenes.exposure import FloatImage, expose
from magicsim.scenes.film import pixel_landing_mm
from magicsim.scenes.scene import OutputSettings, SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.scenes.untouched import UntouchedStates
from magicsim.simulation import Sensor, sensor_exposure
from magicsim.sweep.bootstrap import interval
from magicsim.sweep.measures import Measured
from magicsim.sweep.quality import Quality
from magicsim.sweep.sensors import SweptSensor, camera_of, render_of

Array = npt.NDArray[np.float64]
Pattern = Literal["dots", "lines"]
PLATE_MM = 6.0
"""Side of the plates."""
LOOKED_AT_MM = 5.0
"""Side of the square of the face on which contrast is measured: less than the plate, whose edges are no pattern."""
TOLD_APART = 2.0
"""Least d'."""
ALONG_DEG: dict[Pattern, tuple[float, ...]] = {"lines": (0.0,), "dots": (0.0, 90.0)}
"""Directions in which a pattern repeats [degrees]."""
ACROSS_DEG: dict[Pattern, tuple[float, ...]] = {
    "lines": tuple(float(each) for each in range(40, 141, 10)),
    "dots": (35.0, 40.0, 45.0, 50.0, 55.0, 125.0, 130.0, 135.0, 140.0, 145.0),
}
"""Directions in which it does not."""
MARGIN_PX = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateFrames:
    """Frames of one pressed plate on its place of the face."""

    contrast: Array
    """Change of grey level in units of the untouched sensor's mean, shape (draws, pixels, 3)."""
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
        contrast=contrast,
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


def powers(difference: Array, places_mm: Array, directions_deg: Sequence[float], frequency_per_mm: float) -> Array:
    """Power of a difference at one frequency in several directions, mean over frames and channels.

    A Hann window keeps the square's edges from leaking into other frequencies.

    Args:
        difference: Shape (draws, pixels, 3).
        places_mm: Of the pixels on the face, shape (pixels, 2) [mm].
        directions_deg: Of the wave, from x towards y [degrees].
        frequency_per_mm: Waves a millimetre.

    Returns:
        Shape (directions,): the square of a plane wave's amplitude.
    """
    window = np.prod(np.cos(np.pi * places_mm / LOOKED_AT_MM) ** 2, axis=1)
    turn = np.radians(directions_deg)
    along = places_mm @ np.stack([np.cos(turn), np.sin(turn)])
    waves = np.exp(2j * np.pi * frequency_per_mm * along) * window[:, None]
    found = np.einsum("pw,dpc->wdc", waves, difference, optimize=True) * 2 / window.sum()
    return np.asarray((np.abs(found) ** 2).mean((1, 2)))


def observe(with_pattern: PlateFrames, plain: PlateFrames, pattern: Pattern, spacing_mm: float) -> "Observation":
    """What the d' of one spacing is made of."""
    difference = with_pattern.contrast - plain.contrast
    return Observation(
        pattern=float(powers(difference, plain.places_mm, ALONG_DEG[pattern], 1 / spacing_mm).mean()),
        around=powers(difference, plain.places_mm, ACROSS_DEG[pattern], 1 / spacing_mm),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Observation:
    """Powers at one spacing."""

    pattern: float
    """P."""
    around: Array
    """In directions without the pattern, shape (directions,)."""

    def d_prime(self, directions: npt.NDArray[np.int64] | None = None) -> float:
        """See the module; with the clutter of some directions alone."""
        clutter = float((self.around if directions is None else self.around[directions]).mean())
        return float(np.sqrt(2 * max(0.0, self.pattern - clutter) / clutter))


def smallest_spacing(spacings_mm: Array, observed: Sequence[Observation], *, seed: int) -> Measured:
    """The spacing at which d' falls to 2, between tested ones by their logarithm.

    Args:
        spacings_mm: Falling, shape (spacings,) [mm].
        observed: One for each.
        seed: Of the bootstrap over the clutter's directions.
    """

    def crossing(directions: npt.NDArray[np.int64]) -> float:
        return told_apart_to(spacings_mm, np.array([each.d_prime(directions) for each in observed]))

    count = len(observed[0].around)
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
