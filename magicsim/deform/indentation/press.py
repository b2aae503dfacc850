"""One quasi-static contact: press, then shear, then twist."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation, PathFigures, figures_last
from magicsim.deform.indentation.path_force import PathForce, as_vector
from magicsim.deform.indentation.symmetry import left_by_mirrors, mirror_planes
from magicsim.deform.indentation.timed import body_branches, timed_poses
from magicsim.deform.lattice.structure import Lattice, box_lattice, build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.effort import Progress, part_of
from magicsim.deform.solve.ladder import Rung, named
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConfigError
from magicsim.geometry.design import MAX_DEPTH_SHARE, ElastomerDesign
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.kinds import ObjectBase, SphereObject
from magicsim.notebook.figures import curve, figures_table
from magicsim.waiting import Told, on_stderr, unheard, waiting

MAX_TWIST_DEG = 360.0
MAX_TOLERANCE_MM = 0.1
MAX_FRICTION = 5.0
MAX_SPEED_MM_S = 1e4
MAX_HOLD_S = 1e6
DIGITS = 12
"""Decimal digits of a depth, which is the difference of two heights [mm]."""
MIN_POINTS = 2
"""Places of a path that make a curve."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PressResult(PathFigures):
    """What `magicsim press` reports."""

    force_n: tuple[float, float, float]
    """Force of the object on the sensor [N]; a press is +z."""
    torque_nmm: tuple[float, float, float]
    """Torque about the origin [N mm]."""
    contact_area_mm2: float
    """Deformed area that touches, see `Deformation` [mm2]."""
    seconds: float
    """Wall time of lattice and solve, compilation excluded [s]."""
    history: tuple[PathForce, ...]
    """Every solved place of the path in order: the ends of press, shear and twist, or each step in time."""

    def as_dict(self) -> dict[str, Any]:
        """The keys of the command line's JSON."""
        values = figures_last(self)
        del values["history"]
        return values | {"history": [each.as_dict() for each in self.history]}

    def __str__(self) -> str:
        """One line: force, torque, area."""
        force = ", ".join(f"{each:.3f}" for each in self.force_n)
        torque = ", ".join(f"{each:.3f}" for each in self.torque_nmm)
        return f"force ({force}) N, torque ({torque}) N mm, contact area {self.contact_area_mm2:.2f} mm2"

    def _repr_html_(self) -> str:
        """What a notebook shows: the force along the path, and the figures of its end."""
        values = self.as_dict()
        del values["history"]
        return _force_curve(self.history) + figures_table("Press", values)


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
    tolerance_mm: float = 0.002,
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
        tolerance_mm: Largest penetration at any contact point [mm].
        progress: Told after every iteration, see `Progress`.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        ConfigError: A number is not allowed.
        GeometryError: The design cannot be built.
        ConvergenceError: No valid equilibrium was found.
    """
    check_depth(depth_mm, design)
    for axis, motion, size in zip("xy", shear_mm, design.footprint_mm, strict=True):
        check_number(f"shear_mm along {axis}", motion, -size / 2, size / 2, "half the footprint")
    check_number("twist_deg", twist_deg, -MAX_TWIST_DEG, MAX_TWIST_DEG, "one turn")
    check_friction(friction)
    check_number("tolerance_mm", tolerance_mm, 1e-6, MAX_TOLERANCE_MM, "a tenth of a millimetre")
    _check_time(speed_mm_s, hold_s, twist_deg)
    stages = [((0.0, 0.0), 0.0), (shear_mm, 0.0), (shear_mm, twist_deg)]
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
    with waiting("pressing", told if progress is None else unheard) as share:
        return follow(design, steps, twists, friction=friction, tolerance_mm=tolerance_mm, progress=progress or share)


def follow(
    design: ElastomerDesign,
    steps: Sequence[tuple[Indenter, float]],
    twists_deg: Sequence[float],
    *,
    friction: float,
    tolerance_mm: float,
    progress: Progress | None,
) -> PressResult:
    """Solves a path of poses, each from the one before.

    Args:
        design: The block.
        steps: Poses along the path, and the time that each step takes [s]; infinite on a quasi-static path.
        twists_deg: Turn about z of each pose on the path [degrees].
        friction: Coulomb's coefficient between object and face.
        tolerance_mm: Largest penetration at any contact point [mm].
        progress: Told after every iteration, see `Progress`.

    Raises:
        ConfigError: A path in time, and the body has no relaxation.
        GeometryError: The design cannot be built.
        ConvergenceError: No valid equilibrium was found.
    """
    compile_kernels()
    start = time.perf_counter()
    poses = [pose for pose, _ in steps]
    takes_time = math.isfinite(steps[0][1])
    lattice = build_lattice(design, zone=contact_zone(poses, design))
    solver = ContactSolver(
        lattice,
        tolerance_mm=tolerance_mm,
        friction=friction,
        point_spacing_mm=point_spacing_mm(poses[0].shape),
        branches=body_branches(design, lattice) if takes_time else None,
    )
    states = [Deformation.rest(lattice)]
    for number, (pose, dt) in enumerate(steps):
        told = part_of(progress, number, len(steps)) if progress is not None else None
        states.append(solver.solve(pose, states[-1], dt_s=dt, progress=told))
    seconds = time.perf_counter() - start
    history = _history(states[1:], steps, twists_deg, lattice, solver.face_mm)
    return _summarise(states[1:], history, seconds)


@lru_cache(maxsize=1)
def compile_kernels() -> None:
    """Compiles or loads the kernels by a tiny press, so that the first real solve is timed without it."""
    planes = np.linspace(-1, 1, 3)
    lattice = box_lattice((planes, planes, planes + 1), shear_modulus_mpa=1.0, lame_mpa=10.0)
    ball = SphereObject(kind="sphere", radius_mm=2.0)
    ContactSolver(lattice).solve(place_object(ball, gap_mm=-0.1))


def check_depth(depth_mm: float, design: ElastomerDesign) -> None:
    """Raises ConfigError where a block is too low for a depth [mm]."""
    check_number("depth_mm", depth_mm, 0.0, MAX_DEPTH_SHARE * design.height_mm, "90 % of the height")


def check_friction(friction: float) -> None:
    """Raises ConfigError where a coefficient of friction is not allowed."""
    check_number("friction", friction, 0.0, MAX_FRICTION, "rubber on most solids is below 2")


def check_number(name: str, value: float, low: float, high: float, meaning: str) -> None:
    """Raises ConfigError where a number is not finite or out of its range."""
    if not (math.isfinite(value) and low <= value <= high):
        msg = f"{name} = {value:g} is not allowed: must be {low:g} to {high:g} ({meaning})"
        raise ConfigError(msg)


def _check_time(speed_mm_s: float | None, hold_s: float, twist_deg: float) -> None:
    check_number("hold_s", hold_s, 0.0, MAX_HOLD_S, "eleven days")
    if speed_mm_s is None:
        if hold_s > 0:
            msg = f"hold_s = {hold_s:g} is not allowed without speed_mm_s: a quasi-static path has no time"
            raise ConfigError(msg)
        return
    check_number("speed_mm_s", speed_mm_s, 1e-6, MAX_SPEED_MM_S, "quasi-static inertia-free motion")
    if twist_deg != 0:
        msg = f"twist_deg = {twist_deg:g} is not allowed with speed_mm_s: a timed path presses and shears"
        raise ConfigError(msg)


def _history(
    states: Sequence[Deformation],
    steps: Sequence[tuple[Indenter, float]],
    twists_deg: Sequence[float],
    lattice: Lattice,
    face_mm: Array,
) -> tuple[PathForce, ...]:
    poses = [pose for pose, _ in steps]
    times = np.cumsum([dt for _, dt in steps]).tolist()
    begin, reach_mm = poses[0].pose.position_mm[:2], float(np.abs(face_mm).max())
    far, found = (True, True), []
    for number, (state, pose) in enumerate(zip(states, poses, strict=True)):
        here = mirror_planes(lattice, face_mm, [pose]) if any(far) else (False, False)
        far = (far[0] and here[0], far[1] and here[1])  # what was bent on the way may stay so
        force, torque = left_by_mirrors(state.force_n, state.torque_nmm, far, reach_mm)
        shear_x, shear_y = (pose.pose.position_mm[:2] - begin).tolist()
        found.append(
            PathForce(
                depth_mm=round(max(pose.top_mm(), 0.0), DIGITS),
                shear_mm=(shear_x, shear_y),
                twist_deg=twists_deg[number],
                time_s=times[number] if math.isfinite(times[number]) else None,
                force_n=as_vector(force),
                torque_nmm=as_vector(torque),
                contact_area_mm2=state.contact_area_mm2,
            )
        )
    return tuple(found)


def _force_curve(history: Sequence[object]) -> str:
    """Normal force along a path of several places, against time where it has one, and else against depth."""
    if len(history) < MIN_POINTS:
        return ""
    has_time = all(getattr(each, "time_s", None) is not None for each in history)
    name, label = ("time_s", "time [s]") if has_time else ("depth_mm", "depth [mm]")
    places = [float(getattr(each, name)) for each in history]
    if len(set(places)) < MIN_POINTS:
        return ""
    forces = [float(getattr(each, "force_n")[2]) for each in history]  # noqa: B009
    return curve(places, forces, x_label=label, y_label="normal force [N]")


def _summarise(states: Sequence[Deformation], history: tuple[PathForce, ...], seconds: float) -> PressResult:
    state = states[-1]
    return PressResult(
        force_n=history[-1].force_n,
        torque_nmm=history[-1].torque_nmm,
        contact_area_mm2=state.contact_area_mm2,
        max_penetration_mm=state.max_penetration_mm,
        min_jacobian=state.min_jacobian,
        force_balance=state.force_balance,
        iterations=sum(each.iterations for each in states),
        cutbacks=sum(each.cutbacks for each in states),
        restarts=sum(each.restarts for each in states),
        shifted=sum(each.shifted for each in states),
        rungs=named(frozenset(Rung(name) for each in states for name in each.rungs)),
        unknowns=state.unknowns,
        seconds=seconds,
        converged=state.converged,
        history=history,
    )
