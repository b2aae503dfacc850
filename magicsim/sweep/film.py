"""One design filmed: an approach, a press, touches all over the face and outside light, on one set of references.

All frames of a film share the sensor's untouched state and its Monte Carlo seed; the camera's noise is drawn
afterwards, so that every state can be seen many times for the price of one rendering. A design is filmed several times,
each with random numbers of its own, so that what the rendering's noise does to a measure shows. Every depth is solved
once, in the middle of the face, and moved to each touched place (see `magicsim.deform.lattice.spot`).
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import cycle, pairwise

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, FloatImage, Frame
from magicsim.camera.camera import Camera
from magicsim.camera.exposure import expose
from magicsim.errors import ConfigError
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.light.records.untouched import UntouchedStates
from magicsim.sampling.distribution import unit_points
from magicsim.scenes.refusals import gap_refusal
from magicsim.scenes.scene import FRAMES_PER_SECOND
from magicsim.scenes.timeline import UNTOUCHED, FrameState, with_passing
from magicsim.simulation.sensor import Sensor, sensor_exposure
from magicsim.sweep.designs import SweptSensor, camera_of, render_of
from magicsim.sweep.measures import SweepQuality
from magicsim.sweep.mechanics import CentralPress, followed_finely, moved, press_centrally

PLACES = 3
"""Stream of the touched places."""
DRIFT = 5
"""Stream of the lights' strength."""
FACE_SHARE = 0.5
"""Part of the face, along x and along y, that is touched."""
NEAR_MM = 1.0
"""Gap in front of each touched place [mm]."""
LIGHTS_MM = (-6.0, -2.0, 2.0, 6.0)
"""Places of the outside light along x [mm]."""
REFERENCES = 30
"""Frames of the untouched sensor that make the references, as published."""
PASSED = 6
"""Places, at even times, of what passes in the room while nothing else happens."""
SPAN = 1000
"""Noise streams that each state has for itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shown:
    """One state of the sensor as the camera could see it."""

    number: int
    """Place in the film; states have noise of their own."""
    gap_mm: float | None
    """Negative when pressed; None without an object."""
    x_mm: float
    y_mm: float
    radiance: FloatImage
    """Linear, shape (rows, columns, 3)."""
    at_other_times: tuple[FloatImage, ...] = ()
    """Likewise, while something passes in the room, at other places of its way."""
    force_n: float
    """Along z."""
    seconds: float
    """Time of its rendering, with that of its meshes in the first film [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignFilm:
    """Everything that the image measures of a design are taken from, as one set of random numbers renders it."""

    camera: Camera
    gain: Array
    """Gain of each channel, locked on the untouched sensor, shape (3,)."""
    seed: int
    """Seed of the camera's noise."""
    untouched: Shown
    approach: tuple[Shown, ...]
    """On the axis, gaps falling."""
    press: tuple[Shown, ...]
    """On the axis, depths rising."""
    near: tuple[Shown, ...]
    """In front of each touched place."""
    light_touches: tuple[Shown, ...]
    """The lightest touches that count, in the same order."""
    touches: tuple[Shown, ...]
    """Firmer ones."""
    others: tuple[tuple[Shown, ...], ...]
    """Touches of each further depth that contact is tested at."""
    light: tuple[Shown, ...]
    """Outside light and no object."""

    def frames(self, shown: Shown, draws: int, *, first: int = 0, drift: float = 0.0) -> list[Frame]:
        """A state seen several times, each with noise of its own."""
        start = shown.number * SPAN + first
        random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([self.seed, DRIFT, start])))
        strengths = 1 + drift * random.standard_normal(draws)
        seen = cycle((shown.radiance, *shown.at_other_times))
        return [
            expose((strength * radiance).astype(np.float32), self.gain, self.camera, seed=self.seed, frame=frame)
            for frame, (strength, radiance) in enumerate(zip(strengths, seen, strict=False), start)
        ]

    def references(self) -> list[Frame]:
        """Frames of the untouched sensor that nothing else uses."""
        return self.frames(self.untouched, REFERENCES, first=SPAN - REFERENCES)


def film_design(
    sensors: Sequence[SweptSensor], thing: ObjectConfig, quality: SweepQuality, *, seed: int, untouched: UntouchedStates
) -> list[DesignFilm]:
    """Simulates everything that a film shows, once for each of `quality.renderings`.

    The sensors are the design and what surrounds it as each rendering sees it, see `renderings_of`; they share shape
    and mechanics. Untouched states are those that other scenes share.
    """

    @cache
    def pressed(depth_mm: float) -> CentralPress:
        return press_centrally(sensors[0].design, thing, depth_mm, cells_across=quality.cells_across)

    rig = sensors[0].rig.model_copy(update={"camera": camera_of(sensors[0], quality)})
    # What else looks at the sensor, such as the plates, has the random numbers of the first film.
    first = Sensor(
        followed_finely(sensors[0].design), rig, thing, render=render_of(sensors[0], quality),
        states=_states(sensors[0], quality, seed=seed), seed=seed, untouched=untouched,
    )  # fmt: skip
    first.warm_up(first.states)
    turns = [first, *(_again(first, turn, each, sensors[0], quality) for turn, each in enumerate(sensors[1:], 1))]
    rests = [_untouched(each) for each in turns]
    shown = zip(*_shown(turns, pressed), strict=True)
    return [_film(*each, quality) for each in zip(turns, rests, shown, strict=True)]


def _again(first: Sensor, turn: int, sensor: SweptSensor, base: SweptSensor, quality: SweepQuality) -> Sensor:
    """The first sensor with other random numbers, as another rendering sees it."""
    other = first.reseeded(turn)
    if sensor == base:
        return other
    rig = sensor.rig.model_copy(update={"camera": camera_of(sensor, quality)})
    return other.with_rig(rig, design=None if sensor.design == base.design else followed_finely(sensor.design))


def _untouched(simulated: Sensor) -> tuple[FloatImage, ...]:
    """The untouched sensor in a still room, and with what passes there at even times, if anything does."""
    rig, rest = simulated.rig, simulated.rest
    times_s = () if rig.moving is None else np.arange(PASSED) * rig.moving.every_s / PASSED
    states = [with_passing(UNTOUCHED, rig, time_s=float(time_s), seed=simulated.seed) for time_s in times_s]
    return tuple(simulated.radiance(each, rest) for each in (UNTOUCHED, *states))


def _film(
    simulated: Sensor, rest: tuple[FloatImage, ...], shown: tuple[Shown, ...], quality: SweepQuality
) -> DesignFilm:
    count = 3 + len(quality.contact_depths_mm)
    lengths = [len(quality.gaps_mm), len(quality.depths_mm), count * quality.touches, len(LIGHTS_MM)]
    parts = [shown[first:stop] for first, stop in pairwise(np.cumsum([0, *lengths]).tolist())]
    return DesignFilm(
        camera=simulated.rig.camera,
        gain=sensor_exposure(simulated, rest[0]),
        seed=simulated.seed,
        untouched=Shown(
            number=0, gap_mm=None, x_mm=0.0, y_mm=0.0, radiance=rest[0], at_other_times=rest[1:], force_n=0.0,
            seconds=0.0,
        ),
        approach=parts[0], press=parts[1], near=parts[2][::count], light_touches=parts[2][1::count],
        touches=parts[2][2::count], others=tuple(parts[2][each::count] for each in range(3, count)), light=parts[3],
    )  # fmt: skip


def _shown(turns: Sequence[Sensor], pressed: Callable[[float], CentralPress]) -> Iterator[list[Shown]]:
    """Every state by every turn: a state's meshes are moved, and its search tree is built, once for all of them."""
    first = turns[0]
    for number, state in enumerate(first.states, 1):
        depth = -(state.gap_mm or 0.0)
        press = pressed(depth) if depth > 0 else None
        deformation = moved(first, state, press) if press is not None else first.rest
        before = time.perf_counter()
        view = first.view(state, deformation)
        shown = []
        for each in turns:
            radiance, now = each.renderer.radiance(view), time.perf_counter()
            shown.append(
                Shown(
                    number=number, gap_mm=state.gap_mm, x_mm=state.x_mm, y_mm=state.y_mm, radiance=radiance,
                    force_n=float(press.force_n[2]) if press is not None else 0.0, seconds=now - before,
                )
            )  # fmt: skip
            before = now
        yield shown


def touched_places(sensor: SweptSensor, quality: SweepQuality, *, seed: int) -> npt.NDArray[np.float64]:
    """Places on the face, evenly spread, shape (touches, 2) [mm]; the same shares of the face for every design."""
    shares = unit_points(quality.touches, 2, seed=seed, stream=PLACES, sampling="sobol") - 0.5
    return np.asarray(np.round(FACE_SHARE * shares * np.array(sensor.design.footprint_mm), 3))


def _states(sensor: SweptSensor, quality: SweepQuality, *, seed: int) -> list[FrameState]:
    """States of a film, in order."""
    gaps = [*quality.gaps_mm, *(-depth for depth in quality.depths_mm)]
    states = [replace(UNTOUCHED, gap_mm=gap) for gap in gaps]
    at_places = (
        NEAR_MM,
        -quality.light_depth_mm,
        -quality.touch_depth_mm,
        *(-each for each in quality.contact_depths_mm),
    )
    for x, y in touched_places(sensor, quality, seed=seed).tolist():
        states += [replace(UNTOUCHED, x_mm=x, y_mm=y, gap_mm=gap) for gap in at_places]
    states += [replace(UNTOUCHED, flashlight=True, light_x_mm=x) for x in LIGHTS_MM]
    for gap in (*gaps, *at_places):
        problem = gap_refusal(sensor.design, sensor.rig, gap)
        if problem is not None:
            raise ConfigError(f"gap_mm{problem}")
    times = (number / FRAMES_PER_SECOND for number in range(len(states)))
    return [
        with_passing(state, sensor.rig, time_s=time_s, seed=seed) for state, time_s in zip(states, times, strict=True)
    ]
