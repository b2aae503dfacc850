"""One contact: press, then shear, then twist; and force against depth along one path that is solved once."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from itertools import pairwise

import numpy as np

from magicsim.arrays import Array
from magicsim.config.ranges import check_number, is_number
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation, PathFigures
from magicsim.deform.indentation.path import PathForce, PressResult, path_forces, timed_poses
from magicsim.deform.lattice.core_failure import CoreLaw, weakened
from magicsim.deform.lattice.relaxation import body_branches
from magicsim.deform.lattice.structure import box_lattice, build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.iterate import Progress, part_of
from magicsim.deform.solve.ladder import Rung, rung_names
from magicsim.deform.solve.path import MAX_ITERATIONS, ContactSolver
from magicsim.errors import ConfigError
from magicsim.geometry.design import MAX_DEPTH_SHARE, ElastomerDesign
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.limits import WHOLE, CoreFailure, LimitsWatch
from magicsim.geometry.objects.plain import SphereObject
from magicsim.geometry.objects.rigid_object import ObjectBase
from magicsim.waiting import Told, on_stderr, unheard, waiting

MAX_TWIST_DEG = 360.0
LONGEST_TURN_DEG = 90.0
"""Twist between two places of a path [degrees]: turns of half a circle and more have a shorter way."""
MAX_TOLERANCE_MM = 0.1
MAX_FRICTION = 5.0
MAX_SPEED_MM_S = 1e4
MAX_HOLD_S = 1e6
MOST_ITERATIONS = 1_000_000
RELEASED_MM = 0.5
"""Gap of an object that is lifted off [mm]."""
MAX_POINTS = 1000
"""Most depths of one curve."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PressCurve:
    """Forces and areas of an object in a block at every depth of one press."""

    result: PressResult
    """At the deepest place, with what the whole path has cost; its history is the curve."""

    @property
    def points(self) -> tuple[PathForce, ...]:
        """The depths in order."""
        return self.result.history

    @property
    def depths_mm(self) -> Array:
        """Depths from first contact, shape (points,) [mm]."""
        return np.array([each.depth_mm for each in self.points])

    @property
    def forces_n(self) -> Array:
        """Force of the object on the sensor at each depth, shape (points, 3) [N]."""
        return np.array([each.force_n for each in self.points])

    @property
    def areas_mm2(self) -> Array:
        """Area that touches at each depth, shape (points,) [mm2]."""
        return np.array([each.contact_area_mm2 for each in self.points])


def press(
    design: ElastomerDesign,
    object_config: ObjectBase,
    *,
    depth_mm: float,
    shear_mm: tuple[float, float] = (0.0, 0.0),
    twist_deg: float = 0.0,
    friction: float = 0.0,
    speed_mm_s: float | None = None,
    hold_s: float = 0.0,
    infill_yield_mpa: float | None = None,
    wall_buckling_strain: float | None = None,
    wall_tear_elongation: float | None = None,
    release: bool = False,
    tolerance_mm: float = 0.002,
    max_iterations: int = MAX_ITERATIONS,
    progress: Progress | None = None,
    told: Told = on_stderr,
) -> PressResult:
    """Presses an object into a block; the path is press, then shear, then twist.

    Without a speed the path is quasi-static: the body has its long-term stiffness.

    Args:
        design: The block.
        object_config: The object.
        depth_mm: Depth from first contact along +z [mm].
        shear_mm: Motion along x and y after the press [mm].
        twist_deg: Rotation about z after the shear [degrees].
        friction: Coulomb's coefficient between object and face.
        speed_mm_s: Speed of the object on a path that takes time [mm/s]; the body must have a Prony series.
        hold_s: Time at the end of such a path [s].
        infill_yield_mpa: Shear stress at which the infill flows [MPa]; it never does by default, nor on a timed path.
        wall_buckling_strain: Squeeze along a wall from which on it carries no more; none does by default.
        wall_tear_elongation: Elongation at which walls tear; none does by default, nor on a timed path.
        release: Whether the object is lifted off at the end, which leaves a dent where the infill has flowed.
        tolerance_mm: Largest penetration at any contact point [mm].
        max_iterations: Iterations at one place of the path before the press is given up.
        progress: Told after every iteration, see `Progress`.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        ConfigError: A number is not allowed.
        GeometryError: The design cannot be built.
        ConvergenceError: No valid equilibrium was found.
    """
    check_depth(depth_mm, design)
    for axis, motion, size in zip("xy", shear_mm, design.footprint_mm, strict=True):
        _check_range(f"shear_mm along {axis}", motion, -size / 2, size / 2, "half the footprint")
    _check_range("twist_deg", twist_deg, -MAX_TWIST_DEG, MAX_TWIST_DEG, "one turn")
    _check_time(speed_mm_s, hold_s, twist_deg)
    failure = CoreFailure(
        infill_yield_mpa=infill_yield_mpa, wall_buckling_strain=wall_buckling_strain,
        wall_tear_elongation=wall_tear_elongation,
    )  # fmt: skip
    if speed_mm_s is not None and failure.is_remembered:
        name = "infill_yield_mpa" if infill_yield_mpa is not None else "wall_tear_elongation"
        raise ConfigError(f"{name} is not allowed with speed_mm_s: on a timed path no infill flows and no wall tears")
    if release and not failure.is_remembered:
        raise ConfigError("release is not allowed without infill_yield_mpa or wall_tear_elongation: nothing else lasts")
    turns = max(1, math.ceil(abs(twist_deg) / LONGEST_TURN_DEG))
    stages = [((0.0, 0.0), 0.0), (shear_mm, 0.0), *((shear_mm, twist_deg * (1 + k) / turns) for k in range(turns))]
    stages = [stage for number, stage in enumerate(stages) if number == 0 or stage != stages[number - 1]]
    poses = [
        place_object(object_config, gap_mm=-depth_mm, x_mm=shear[0], y_mm=shear[1], twist_deg=twist, design=design)
        for shear, twist in stages
    ]
    steps = [(pose, math.inf) for pose in poses]
    if speed_mm_s is not None:
        first = place_object(object_config, gap_mm=0.0, design=design)
        lengths = [depth_mm, math.hypot(*shear_mm)][: len(poses)]
        steps = list(timed_poses([first, *poses], lengths, speed_mm_s=speed_mm_s, hold_s=hold_s))
    twists = [0.0] * len(steps) if speed_mm_s is not None else [twist for _, twist in stages]
    if release:
        (x, y), twist = stages[-1]
        for gap in (0.0, RELEASED_MM):
            pose = place_object(object_config, gap_mm=gap, x_mm=x, y_mm=y, twist_deg=twist, design=design)
            steps.append((pose, math.inf))
        twists += [twist, twist]
    return _followed(
        "pressing", design, steps, twists, friction=friction, failure=failure, tolerance_mm=tolerance_mm,
        max_iterations=max_iterations, progress=progress, told=told,
    )  # fmt: skip


def press_curve(
    design: ElastomerDesign,
    object_config: ObjectBase,
    depths_mm: Sequence[float] | Array,
    *,
    friction: float = 0.0,
    infill_yield_mpa: float | None = None,
    wall_buckling_strain: float | None = None,
    wall_tear_elongation: float | None = None,
    tolerance_mm: float = 0.002,
    max_iterations: int = MAX_ITERATIONS,
    progress: Progress | None = None,
    told: Told = on_stderr,
) -> PressCurve:
    """Presses an object deeper and deeper into a block; quasi-static.

    One lattice, fine where the deepest press touches, carries the whole curve, and each depth starts from the one
    before. Components that symmetry forbids are exactly zero (`left_by_mirrors`).

    Args:
        design: The block.
        object_config: The object.
        depths_mm: Depths from first contact along +z, each larger than the one before [mm].
        friction: Coulomb's coefficient between object and face.
        infill_yield_mpa: Shear stress at which the infill flows [MPa]; it never does by default.
        wall_buckling_strain: Squeeze along a wall from which on it carries no more; none does by default.
        wall_tear_elongation: Elongation at which walls tear; none does by default.
        tolerance_mm: Largest penetration at any contact point [mm].
        max_iterations: Iterations at one place of the path before the press is given up.
        progress: Told after every iteration, see `Progress`.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        ConfigError: A number is not allowed.
        GeometryError: The design cannot be built.
        ConvergenceError: A depth has no valid equilibrium.
    """
    depths = [float(depth) for depth in depths_mm]
    if not 1 <= len(depths) <= MAX_POINTS:
        raise ConfigError(f"depths_mm has {len(depths)} depths: 1 to {MAX_POINTS} are allowed")
    for depth in depths:
        check_depth(depth, design)
    for low, high in pairwise(depths):
        if not low < high:
            msg = f"depths_mm = {high:g} after {low:g} is not allowed: each depth must be larger than the one before"
            raise ConfigError(msg)
    steps = [(place_object(object_config, gap_mm=-depth, design=design), math.inf) for depth in depths]
    failure = CoreFailure(
        infill_yield_mpa=infill_yield_mpa, wall_buckling_strain=wall_buckling_strain,
        wall_tear_elongation=wall_tear_elongation,
    )  # fmt: skip
    result = _followed(
        "pressing deeper and deeper", design, steps, [0.0] * len(steps), friction=friction, failure=failure,
        tolerance_mm=tolerance_mm, max_iterations=max_iterations, progress=progress, told=told,
    )  # fmt: skip
    return PressCurve(result=result)


def _followed(
    doing: str, design: ElastomerDesign, steps: Sequence[tuple[Indenter, float]], twists_deg: Sequence[float], *,
    friction: float, failure: CoreFailure, tolerance_mm: float, max_iterations: int, progress: Progress | None,
    told: Told,
) -> PressResult:  # fmt: skip
    """Solves a path, and warns where the place of its largest force is beyond what the block bears."""
    check_friction(friction)
    check_number("max_iterations", max_iterations, 1, MOST_ITERATIONS, whole=True)
    _check_range("tolerance_mm", tolerance_mm, 1e-6, MAX_TOLERANCE_MM, "a tenth of a millimetre")
    with waiting(doing, told if progress is None else unheard) as share:
        result = follow(
            design, steps, twists_deg, friction=friction, failure=failure, tolerance_mm=tolerance_mm,
            max_iterations=max_iterations, progress=progress or share,
        )  # fmt: skip
    most = max(result.history, key=lambda place: place.force_n[2])
    excess = design.limits.excess(depth_mm=most.depth_mm, force_n=most.force_n[2], area_mm2=most.contact_area_mm2)
    LimitsWatch(design.limits).see(excess)
    return result


def follow(
    design: ElastomerDesign,
    steps: Sequence[tuple[Indenter, float]],
    twists_deg: Sequence[float],
    *,
    friction: float,
    failure: CoreFailure = WHOLE,
    tolerance_mm: float,
    max_iterations: int = MAX_ITERATIONS,
    progress: Progress | None,
) -> PressResult:
    """Solves a path of poses, each from the one before; arguments and errors are those of `press`.

    Each of the steps has the time that it takes [s], infinite on a quasi-static path, and the turn about z of its pose.
    """
    compile_kernels()
    start = time.perf_counter()
    poses = [pose for pose, _ in steps]
    lattice = weakened(build_lattice(design, zone=contact_zone(poses, design)), failure)
    solver = ContactSolver(
        lattice,
        tolerance_mm=tolerance_mm,
        max_iterations=max_iterations,
        friction=friction,
        point_spacing_mm=point_spacing_mm(poses[0].shape),
        branches=body_branches(design, lattice) if math.isfinite(steps[0][1]) else None,
        core=CoreLaw.of(design, lattice, failure),
    )
    states: list[Deformation] = []
    for number, (pose, dt) in enumerate(steps):
        share = part_of(progress, number, len(steps)) if progress is not None else None
        states.append(solver.solve(pose, states[-1] if states else None, dt_s=dt, progress=share))
    seconds = time.perf_counter() - start
    history = path_forces(states, steps, twists_deg, lattice, solver.face_mm)
    figures = {each.name: getattr(states[-1], each.name) for each in fields(PathFigures)}
    for name in ("iterations", "cutbacks", "restarts", "shifted"):
        figures[name] = sum(getattr(each, name) for each in states)
    figures["rungs"] = rung_names(frozenset(Rung(name) for each in states for name in each.rungs))
    return PressResult(
        force_n=history[-1].force_n,
        torque_nmm=history[-1].torque_nmm,
        contact_area_mm2=states[-1].contact_area_mm2,
        seconds=seconds,
        history=history,
        **figures,
    )


@lru_cache(maxsize=1)
def compile_kernels() -> None:
    """Compiles or loads the kernels by a tiny press, so that the first real solve is timed without it."""
    planes = np.linspace(-1, 1, 3)
    lattice = box_lattice((planes, planes, planes + 1), shear_modulus_mpa=1.0, lame_mpa=10.0)
    ball = SphereObject(kind="sphere", radius_mm=2.0)
    ContactSolver(lattice).solve(place_object(ball, gap_mm=-0.1))


def check_depth(depth_mm: float, design: ElastomerDesign) -> None:
    """Raises ConfigError where a block is too low for a depth [mm]."""
    _check_range("depth_mm", depth_mm, 0.0, MAX_DEPTH_SHARE * design.height_mm, "90 % of the height")


def check_friction(friction: float) -> None:
    """Raises ConfigError where a coefficient of friction is not allowed."""
    _check_range("friction", friction, 0.0, MAX_FRICTION, "rubber on most solids is below 2")


def _check_range(name: str, value: float, low: float, high: float, meaning: str) -> None:
    """Raises ConfigError where a number is not finite or out of its range."""
    if not (is_number(value) and math.isfinite(value) and low <= value <= high):
        shown = f"{value:g}" if is_number(value) else repr(value)
        raise ConfigError(f"{name} = {shown} is not allowed: must be {low:g} to {high:g} ({meaning})")


def _check_time(speed_mm_s: float | None, hold_s: float, twist_deg: float) -> None:
    _check_range("hold_s", hold_s, 0.0, MAX_HOLD_S, "eleven days")
    if speed_mm_s is None:
        if hold_s > 0:
            raise ConfigError(f"hold_s = {hold_s:g} is not allowed without speed_mm_s: a quasi-static path has no time")
        return
    _check_range("speed_mm_s", speed_mm_s, 1e-6, MAX_SPEED_MM_S, "quasi-static inertia-free motion")
    if twist_deg != 0:
        raise ConfigError(f"twist_deg = {twist_deg:g} is not allowed with speed_mm_s: a timed path presses and shears")
