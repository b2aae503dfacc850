"""Paths of an object, their steps in time, and what it does to a sensor along them.

A press that takes time needs a body with a Prony series (`materials.body.prony`). The object moves at a constant speed
and then stays; time steps are even on the way and grow geometrically at hold, where the response slows down.

**Symmetry.** Where block, face, object and path are their own mirror images in the plane x = 0, so is the equilibrium
that the path reaches. A force has no component across a mirror plane, and a torque, which is an axial vector, none in
it: x = 0 leaves F_y, F_z and T_x. A solve meets that to its tolerance; what is within it is exactly zero.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array
from magicsim.deform.deformation import Deformation, PathFigures, figures_last
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.indenter import Indenter
from magicsim.notebook import curve, figures_table

STEP_MM = 0.1
"""Motion of the object in one time step [mm]: assumed."""
HOLD_STEPS = 8
"""Time steps a decade at hold: assumed."""
FIRST_HOLD_S = 0.01
"""Length of the first time step at hold [s]: assumed."""
DIGITS = 12
"""Decimal digits of a depth, which is the difference of two heights [mm]."""
MIN_POINTS = 2
"""Places of a path that make a curve."""
PLANE_SHARE = 1e-9
"""Largest distance of mirrored node planes, in units of the block's size."""
SHAPE_MM = 1e-6
"""Largest difference of an object's distances at mirrored points [mm]: meshes of solids round."""
FORCE_SHARE = 1e-5
"""Largest solved component that counts as zero, in units of the force; equilibria are solved to 1e-7 or so. More of it
is a body that has buckled out of its symmetry, and stays what it is."""
LEVELS = 4
"""Heights of the face at which an object is compared with its mirror image."""
Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class PathForce:
    """One place of a path, solved."""

    depth_mm: float
    """Depth from first contact [mm]."""
    shear_mm: tuple[float, float]
    """Motion along x and y since then [mm]."""
    twist_deg: float
    """Rotation about z since then [degrees]."""
    time_s: float | None
    """Since first contact [s]; None on a quasi-static path, which has no time."""
    force_n: Vector
    """Force of the object on the sensor [N]; a press is +z."""
    torque_nmm: Vector
    """Torque about the origin [N mm]."""
    contact_area_mm2: float
    """Deformed area that touches, see `Deformation` [mm2]."""
    dissipated_nmm: float | None = None
    """Energy that flow and tears have taken so far [N mm]; None where the core cannot fail."""
    torn_cells: int | None = None
    """Printed cells whose walls have torn; None where they cannot."""
    dent_mm: float | None = None
    """Deepest point of the contact face [mm]; None where the core cannot fail."""

    def as_dict(self) -> dict[str, Any]:
        """The keys of the command line's JSON; no time where there is none, and no failure."""
        return {key: value for key, value in asdict(self).items() if value is not None}


def as_vector(values: npt.NDArray[np.float64]) -> Vector:
    """Three numbers of an array, shape (3,)."""
    x, y, z = values.tolist()
    return (x, y, z)


@dataclass(frozen=True, slots=True, kw_only=True)
class PressResult(PathFigures):
    """Result of a press, as `magicsim press` reports it."""

    force_n: Vector
    """Force of the object on the sensor [N]; a press is +z."""
    torque_nmm: Vector
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
        """Force along the path and the figures of its end, for notebooks."""
        values = self.as_dict()
        del values["history"]
        return _force_curve(self.history) + figures_table("Press", values)


def timed_poses(
    poses: list[Indenter], lengths_mm: list[float], *, speed_mm_s: float, hold_s: float
) -> Iterator[tuple[Indenter, float]]:
    """Poses along a path with the time that each step takes [s].

    `poses` are first contact and the ends of straight stages, with their lengths; the object is held at the last one.
    """
    for (start, end), length in zip(pairwise(poses), lengths_mm, strict=True):
        steps = max(1, math.ceil(length / STEP_MM - 1e-9))
        for number in range(1, steps + 1):
            share = number / steps
            position = (1 - share) * start.pose.position_mm + share * end.pose.position_mm
            yield replace(end, pose=replace(end.pose, position_mm=position)), length / steps / speed_mm_s
    if hold_s > 0:
        first = min(FIRST_HOLD_S, hold_s)
        count = math.ceil(HOLD_STEPS * math.log10(hold_s / first)) + 1
        for low, high in pairwise([0.0, *np.geomspace(first, hold_s, count).tolist()]):
            yield poses[-1], high - low


def path_forces(
    states: Sequence[Deformation],
    steps: Sequence[tuple[Indenter, float]],
    twists_deg: Sequence[float],
    lattice: Lattice,
    face_mm: Array,
) -> tuple[PathForce, ...]:
    """Forces at the places of a path, components that symmetry forbids exactly zero.

    Each place has an equilibrium, a pose with the time that its step takes [s], infinite on a quasi-static path, and
    the turn about z; `face_mm` are the contact points of the undeformed face.
    """
    times = np.cumsum([dt for _, dt in steps]).tolist()
    begin, reach_mm = steps[0][0].pose.position_mm[:2], float(np.abs(face_mm).max())
    mirrors, forces = [True, True], []
    for number, (state, (pose, _)) in enumerate(zip(states, steps, strict=True)):
        # what was bent on the way may stay so
        mirrors = [was and _is_mirrored(lattice, face_mm, pose, axis) for axis, was in enumerate(mirrors)]
        force, torque = left_by_mirrors(state.force_n, state.torque_nmm, mirrors, reach_mm)
        deepest = float(state.displacements_mm[: lattice.layer_nodes, 2].max())
        shear_x, shear_y = (pose.pose.position_mm[:2] - begin).tolist()
        forces.append(
            PathForce(
                depth_mm=round(max(pose.depth_mm(lattice.face, lattice.footprint_mm), 0.0), DIGITS),
                shear_mm=(shear_x, shear_y),
                twist_deg=twists_deg[number],
                time_s=times[number] if math.isfinite(times[number]) else None,
                force_n=as_vector(force),
                torque_nmm=as_vector(torque),
                contact_area_mm2=state.contact_area_mm2,
                dissipated_nmm=state.core.dissipated_nmm if state.core is not None else None,
                torn_cells=int(state.core.torn.sum()) if state.core is not None and len(state.core.torn) else None,
                dent_mm=deepest if state.core is not None else None,
            )
        )
    return tuple(forces)


def left_by_mirrors(force_n: Array, torque_nmm: Array, planes: Sequence[bool], reach_mm: float) -> Array:
    """Force and torque, shape (2, 3) [N, N mm]; exactly zero where mirror planes leave nothing.

    `planes` says whether x = 0 and y = 0 mirror the contact; the torque is about a point of both, `reach_mm` the
    largest lever of the force [mm].
    """
    components = np.stack([force_n, torque_nmm]).astype(np.float64)
    least = FORCE_SHARE * float(np.linalg.norm(force_n)) * np.array([1.0, reach_mm])
    for axis, mirrors in enumerate(planes):
        gone = np.zeros((2, 3), bool)
        gone[0, axis] = gone[1, 1 - axis] = gone[1, 2] = True
        if mirrors and (np.abs(components) <= least[:, None])[gone].all():
            components[gone] = 0.0
    return components


def _is_mirrored(lattice: Lattice, face_mm: Array, indenter: Indenter, axis: int) -> bool:
    """Whether a block and an object pressed into it are their own mirror images in x = 0 (0) or y = 0 (1)."""
    planes = lattice.planes_mm[axis]
    if lattice.is_mirrored or np.abs(planes + planes[::-1]).max() > PLANE_SHARE * float(np.ptp(planes)):
        return False
    cells = tuple(len(each) - 1 for each in reversed(lattice.planes_mm))
    for modulus in (lattice.shear_modulus_mpa, lattice.wall_modulus_mpa, lattice.lame_mpa):
        if not np.array_equal(modulus.reshape(cells), np.flip(modulus.reshape(cells), 2 - axis)):
            return False
    flip = np.ones(3)
    flip[axis] = -1
    # the object's distance has to be even across the plane, at the face and at the heights that it was lifted to
    for level in np.linspace(0, max(indenter.top_mm(), 0.0), LEVELS):
        points = face_mm + np.array([0.0, 0.0, level])
        here, there = (indenter.distance(each)[0] for each in (points, points * flip))
        if np.abs(here - there).max() > SHAPE_MM:
            return False
    return True


def _force_curve(history: Sequence[PathForce]) -> str:
    """Normal force along a path of several places, against time where it has one, and else against depth."""
    times = [each.time_s for each in history if each.time_s is not None]
    has_time = len(times) == len(history)
    places, label = (times, "time [s]") if has_time else ([each.depth_mm for each in history], "depth [mm]")
    if len(set(places)) < MIN_POINTS:
        return ""
    forces = [each.force_n[2] for each in history]
    return curve(places, forces, x_label=label, y_label="normal force [N]")
