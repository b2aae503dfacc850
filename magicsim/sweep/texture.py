"""The smallest spacing of dots and lines that a frame still shows.

A plate with the pattern and one without are pressed alike in the middle of the face, and D is the difference of their
frames on the plate's place in units of the untouched sensor's grey level: what only the pattern makes, the printed grid
taken out. P is D's power at the pattern's spatial frequency along its own axes, P_0 the mean power at that frequency in
other directions, where the pattern has none: noise of camera and rendering, and cells that moved otherwise. For a
pattern of known frequency and phase in Gaussian clutter

    d' = sqrt(2 (P - P_0) / P_0)

(Green and Swets 1966), 0 where P is below P_0. A spacing is told apart at d' >= 2, so P >= 3 P_0, which clutter alone
reaches in 5 to 10 % of cases. P / P_0 follows the noncentral F distribution, which says what d' the frames allow.

Plate, lattice and the part that is looked at grow with the spacing, so that every spacing is judged alike. Dots and
lines are their own mirror images about the axis: a quarter of the block is solved.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.stats import ncf

from magicsim.arrays import Array, FloatImage
from magicsim.camera.camera import Window
from magicsim.camera.exposure import expose
from magicsim.camera.projection import picture_mm, pixel_landing_mm
from magicsim.deform.indentation.force import find_depth
from magicsim.detectors.frame import Frame
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.geometry.objects.plain import BoxObject
from magicsim.geometry.objects.textured import CELLS_A_PERIOD, DotsObject, LinesObject
from magicsim.judge.measures import RESAMPLES, TAIL
from magicsim.light.records.untouched import UntouchedStates
from magicsim.notebook.screen import beside_change
from magicsim.scenes.rig import Rig
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor, sensor_exposure
from magicsim.sweep.designs import SweptSensor, camera_of, render_of
from magicsim.sweep.measures import Measured, SweepQuality
from magicsim.sweep.mechanics import CentralPress, followed_finely, moved, press_centrally

Pattern = Literal["dots", "lines"]
PLATE_PERIODS = 5
"""Side of the plates in units of the spacing."""
LOOKED_AT_PERIODS = 4
"""Side of the square of the face on which contrast is measured, in the same units: less than the plate, whose edges are
no pattern, and enough for the peak of the pattern's frequency to be narrow."""
NODES_A_PERIOD, FACETS_A_PERIOD, PIXELS_A_PERIOD = 4, 4, 3
"""Nodes that carry displacements to the meshes, rendered facets and pixels along one spacing, at least."""
MARGIN_PX = 2
MOST_DEPTH_MM = 2.5
"""Depth at which a press to a force ends on a design without limits [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateFrames:
    """Frames of one pressed plate on its place of the face."""

    contrast: Array
    """Change of grey level in units of the untouched sensor's mean, shape (draws, pixels, 3)."""
    places_mm: Array
    """Where the pixels look on the face, shape (pixels, 2) [mm]."""
    picture: Frame
    """The first frame, whole, beside its change."""


def plate(pattern: Pattern | None, spacing_mm: float, like: ObjectConfig | None = None) -> ObjectConfig:
    """A plate with dots or lines half as wide as their spacing, or without, with the colour of another object."""
    size = PLATE_PERIODS * spacing_mm
    look = like.model_dump(include={"color", "specular", "roughness"}) if like is not None else {}
    if pattern == "dots":
        return DotsObject(kind="dots", radius_mm=spacing_mm / 4, spacing_mm=spacing_mm, size_mm=size, **look)
    if pattern == "lines":
        return LinesObject(kind="lines", width_mm=spacing_mm / 2, spacing_mm=spacing_mm, size_mm=size, **look)
    return BoxObject(kind="box", size_mm=(size, size, 2.0), **look)


def press_plate(
    sensor: SweptSensor,
    pattern: Pattern | None,
    spacing_mm: float,
    quality: SweepQuality,
    *,
    like: ObjectConfig,
    seed: int,
    untouched: UntouchedStates,
) -> PlateFrames:
    """Presses a plate, coloured like another object, on the axis and looks at its place.

    A plain plate has the size of one with a pattern of the spacing, which it is compared with.
    """
    if PLATE_PERIODS * spacing_mm > min(sensor.design.footprint_mm):
        raise ConfigError(f"a plate of {PLATE_PERIODS} x {spacing_mm:g} mm is larger than the face")
    thing = plate(pattern, spacing_mm, like)
    rig = plate_rig(sensor, spacing_mm, quality)
    design = followed_finely(sensor.design, near_mm=spacing_mm / NODES_A_PERIOD)
    cells = CELLS_A_PERIOD if pattern is not None else CELLS_A_PERIOD / 2  # a plain plate bends the face less
    pressed, depth_mm = press_as_asked(sensor.design, thing, quality, spacing_mm=spacing_mm / cells)
    state, render = replace(UNTOUCHED, gap_mm=-depth_mm), render_of(sensor, quality)
    render = render.model_copy(update={"facet_mm": min(render.facet_mm, spacing_mm / FACETS_A_PERIOD)})
    simulated = Sensor(design, rig, thing, render=render, states=[state], seed=seed, untouched=untouched)
    rest = simulated.radiance(UNTOUCHED, simulated.rest)
    image = simulated.radiance(state, moved(simulated, state, pressed))
    camera, exposure = rig.camera, sensor_exposure(simulated, rest)

    def frames(radiance: FloatImage, first: int) -> Array:
        return np.stack(
            [expose(radiance, exposure, camera, seed=seed, frame=first + draw) for draw in range(quality.draws)]
        ).astype(float)

    # A plain plate is seen by frames of its own: their noise would cancel in the difference.
    shown = frames(image, 0 if pattern is not None else 2 * quality.draws)
    reference = frames(rest, quality.draws).mean(0)
    landing = pixel_landing_mm(design, rig.lens, rig.camera)
    inside = np.abs(landing).max(2) <= LOOKED_AT_PERIODS * spacing_mm / 2
    contrast = ((shown - reference) / reference[inside].mean(0))[:, inside]
    picture = beside_change(shown[0].astype(np.uint8), reference, gamma=camera.gamma)
    return PlateFrames(contrast=contrast, places_mm=landing[inside], picture=picture)


def press_as_asked(
    design: ElastomerDesign, thing: ObjectConfig, quality: SweepQuality, *, spacing_mm: float
) -> tuple[CentralPress, float]:
    """The press as deep or as hard as it is asked for, and how deep that is [mm]."""
    if quality.texture_force_n is None:
        depth = quality.texture_depth_mm
        return press_centrally(design, thing, depth, cells_across=1, spacing_mm=spacing_mm), depth
    pressed: dict[float, CentralPress] = {}

    def force_n(depth_mm: float) -> float:
        pressed[depth_mm] = press_centrally(design, thing, depth_mm, cells_across=1, spacing_mm=spacing_mm)
        return float(pressed[depth_mm].force_n[2])

    found = find_depth(force_n, quality.texture_force_n, deepest_mm=design.limits.depth_mm or MOST_DEPTH_MM)
    if found.depth_mm not in pressed:
        raise ConfigError(f"quality.texture_force_n = {quality.texture_force_n:g} is not met: each press has more")
    return pressed[found.depth_mm], found.depth_mm


def plate_rig(sensor: SweptSensor, spacing_mm: float, quality: SweepQuality) -> Rig:
    """The rig of a sensor, its camera reading out what lies around a plate of `PLATE_PERIODS` spacings.

    Raises:
        ConfigError: The sensor's own camera has too few pixels for the spacing, or does not see the plate's place.
    """
    own, field = sensor.rig.camera.columns, sensor.rig.camera.field_mm
    needed = math.ceil(PIXELS_A_PERIOD * field / spacing_mm)
    columns = camera_of(sensor, quality).columns
    scale = max(quality.texture_scale, math.ceil(needed / columns))
    if scale > max(quality.texture_scale, math.ceil(own / columns)):
        raise ConfigError(f"rig.camera.columns = {own} is too few for {spacing_mm:g} mm: must be at least {needed}")
    camera = camera_of(sensor, quality, scale=scale)
    lens, half_mm = sensor.rig.lens, LOOKED_AT_PERIODS * spacing_mm / 2
    if np.abs(picture_mm(sensor.design, lens, camera)).min() < half_mm - field / camera.columns:
        raise ConfigError(f"the camera sees less of the face than {2 * half_mm:g} mm, {LOOKED_AT_PERIODS} spacings")
    near = np.abs(pixel_landing_mm(sensor.design, lens, camera)).max(2) <= PLATE_PERIODS * spacing_mm / 2
    (top, *_, bottom), (left, *_, right) = (np.flatnonzero(near.any(axis)).tolist() for axis in (1, 0))
    seen = Window(column=left, row=top, columns=right + 1 - left, rows=bottom + 1 - top)
    read = seen.grown(MARGIN_PX, camera.columns, camera.rows)
    region = (read.column, read.row, read.columns, read.rows)
    looking = camera.pixelwise().model_copy(update={"region_px": region})
    return sensor.rig.model_copy(update={"camera": looking})


TOLD_APART = 2.0
"""Least d'."""
ALONG_DEG: dict[Pattern, tuple[float, ...]] = {"lines": (0.0,), "dots": (0.0, 90.0)}
"""Directions in which a pattern repeats [degrees]."""
ACROSS_DEG: dict[Pattern, tuple[float, ...]] = {
    "lines": tuple(float(each) for each in range(40, 141, 10)),
    "dots": (35.0, 40.0, 45.0, 50.0, 55.0, 125.0, 130.0, 135.0, 140.0, 145.0),
}
"""Directions in which it does not, beyond the width of its peak."""
MOST_RATIO = 1e3
"""Ratio P / P_0 beyond which a spacing is told apart for sure."""
Complex = npt.NDArray[np.complex128]


def plane_waves(places_mm: Array, directions_deg: Sequence[float], frequency_per_mm: float) -> Complex:
    """What takes the amplitude of each direction out of an image, shape (pixels, directions).

    A Hann window over `LOOKED_AT_PERIODS` keeps the square's edges from leaking into other frequencies. Places on the
    face have shape (pixels, 2) [mm], and directions go from x towards y [degrees].
    """
    window = np.prod(np.cos(np.pi * places_mm * frequency_per_mm / LOOKED_AT_PERIODS) ** 2, axis=1)
    turn = np.radians(directions_deg)
    along = places_mm @ np.stack([np.cos(turn), np.sin(turn)])
    return np.asarray(np.exp(2j * np.pi * frequency_per_mm * along) * window[:, None] * 2 / window.sum())


def observe(with_pattern: PlateFrames, plain: PlateFrames, pattern: Pattern, spacing_mm: float) -> "PatternPowers":
    """What the d' of one spacing is made of."""
    count, directions = len(ALONG_DEG[pattern]), ALONG_DEG[pattern] + ACROSS_DEG[pattern]
    waves = plane_waves(plain.places_mm, directions, 1 / spacing_mm)
    found = np.einsum("pw,dpc->wdc", waves, with_pattern.contrast - plain.contrast, optimize=True)
    powers = np.mean(np.abs(found) ** 2, axis=(1, 2))
    views = _independent(found[count:].reshape(len(directions) - count, -1))
    return PatternPowers(
        pattern=float(powers[:count].mean()), around=powers[count:], pattern_parts=views * count,
        clutter_parts=views * _independent(waves[:, count:].T),
    )  # fmt: skip


def _independent(rows: Complex) -> float:
    """How many independent ones there are among rows or, by the same number, columns that are alike in part."""
    products = np.abs(rows @ rows.conj().T) ** 2
    return float(np.trace(np.sqrt(products)) ** 2 / products.sum())


@dataclass(frozen=True, slots=True, kw_only=True)
class PatternPowers:
    """Powers at one spacing."""

    pattern: float
    """P."""
    around: Array
    """Powers in directions without the pattern, shape (directions,)."""
    pattern_parts: float
    """How many independent complex amplitudes P is the mean of."""
    clutter_parts: float
    """How many P_0 is the mean of: directions next to each other are alike in part, and so are colours and frames."""

    @property
    def ratio(self) -> float:
        """P / P_0."""
        return self.pattern / max(float(self.around.mean()), np.finfo(float).tiny)

    def d_prime(self) -> float:
        """See the module."""
        return math.sqrt(2 * max(0.0, self.ratio - 1))

    def allowed(self, shares: Array) -> Array:
        """The d' above which the ratio would be as high as it is, or higher, in these shares of cases; 0 without one.

        Even shares in 0..1 draw from the confidence distribution of d' (Schweder and Hjort 2002).
        """
        freedom, clutter_freedom = 2 * self.pattern_parts, 2 * self.clutter_parts
        ratio = min(self.ratio, MOST_RATIO)
        tried = np.linspace(0, 3 * math.sqrt(2 * ratio) + 6, 200)
        above = ncf.sf(ratio, freedom, clutter_freedom, freedom * tried**2 / 2)
        return np.asarray(np.interp(shares, np.maximum.accumulate(above), tried))


def smallest_spacing(spacings_mm: Array, observed: Sequence[PatternPowers], *, seed: int) -> Measured:
    """The spacing at which d' falls to 2, between tested ones, which fall, by their logarithm.

    The interval is that of what d' each spacing may have, open where no tested spacing is on the other side.
    """
    random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, len(observed)])))
    drawn = np.stack([each.allowed(random.random(RESAMPLES)) for each in observed], axis=1)
    value = float(told_apart_to(spacings_mm, np.array([each.d_prime() for each in observed])))
    drawn_mm = told_apart_to(spacings_mm, drawn)
    ends = np.quantile(drawn_mm, [TAIL, 1 - TAIL], method="closest_observation")
    finest, coarsest = float(spacings_mm[-1]), float(spacings_mm[0])
    low = min(float(ends[0]), coarsest) if ends[0] > finest else None
    high = float(ends[1]) if np.isfinite(ends[1]) else None
    if value == np.inf:
        return Measured(value=None, low=low, note=f"above the largest spacing tried, {coarsest:g} mm")
    if value <= finest:
        return Measured(value=value, high=high, note="at most: the smallest spacing tried is told apart")
    return Measured(value=value, low=low, high=high)


def told_apart_to(spacings_mm: Array, d_prime: Array) -> Array:
    """Smallest spacing with a d' of 2, between the finest told apart and the next finer one [mm]; infinite without.

    d' of each spacing has shape (..., spacings), what it gives shape (...).
    """
    count = len(spacings_mm)
    told = d_prime >= TOLD_APART
    last = count - 1 - np.argmax(told[..., ::-1], axis=-1)
    following = np.minimum(last + 1, count - 1)
    here, there = (np.take_along_axis(d_prime, each[..., None], -1)[..., 0] for each in (last, following))
    share = np.where(here > there, (here - TOLD_APART) / np.where(here > there, here - there, 1), 0)
    found = spacings_mm[last] * (spacings_mm[following] / spacings_mm[last]) ** share
    return np.asarray(np.where(told.any(-1), found, np.inf))
