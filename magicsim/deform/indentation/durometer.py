"""Shore A hardness as a contact problem (ASTM D2240, type A).

A truncated cone sticks out of a flat presser foot that lies on the sample. A spring pushes the cone with
F = 0.55 + 0.075 S newtons when it sticks out by d = 2.5 (1 - S / 100) millimetres; the hardness S is where the sample
pushes back with the same force. The sample lies loose on a rigid table, as the standard asks for, whatever holds the
sensor; the foot keeps the face around the cone from rising above its plane. The cone presses on the centre of a cell or
on a crossing of walls, which are places of symmetry: a quarter of the sample is solved.
"""

import logging
import time
from dataclasses import dataclass
from typing import Literal

import numpy as np

from magicsim.config.ranges import check_number
from magicsim.deform.deformation import Deformation, SolveFigures
from magicsim.deform.indentation.press import check_friction, compile_kernels
from magicsim.deform.lattice.core_failure import CoreLaw, weakened
from magicsim.deform.lattice.spot import central_lattice, resolved_lattice
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.zone import Zone
from magicsim.deform.solve.iterate import Progress
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConfigError, ConvergenceError
from magicsim.geometry.design import ElastomerDesign, Mounting
from magicsim.geometry.face_shape import HeightMap
from magicsim.geometry.grid import Place, symmetric_place
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.limits import WHOLE, CoreFailure
from magicsim.geometry.pose import Pose
from magicsim.geometry.shapes.revolved import FOOT_RADIUS_MM, SHAFT_RADIUS_MM, DurometerTool
from magicsim.waiting import Told, on_stderr, unheard, waiting

Walls = Literal["resolved", "homogenised", "none"]
LOGGER = logging.getLogger(__name__)
EXTENSION_MM = 2.5
"""How far the cone sticks out at S = 0 [mm]: ASTM D2240."""
SPRING_N = (0.55, 0.075)
"""Force of the spring at S = 0 and per unit of S [N]: ASTM D2240."""
SPACING_MM = 0.4
"""Node spacing under the cone by default [mm]."""
MARGINS_MM = (0.85, 1.5)
"""How far around the cone and how deep below the skin the lattice is fine, with walls resolved, and in a block without
walls [mm]; three times as far changes the force by 1.5 %, the hardness of a plain block by 0.2."""
GROWTH = 2.2
"""Ratio of neighbouring spacings away from the cone: assumed."""
STEP_MM = 0.125
"""Motion of the cone in one load step [mm]: assumed."""
SPACINGS_MM, LEAST_STEP_MM = (0.02, 10.0), 1e-3
"""Node spacings that are allowed, and the least motion in one load step [mm]: assumed."""
FRICTION = 1.0
"""Friction of rubber on the tool; assumed, 0.3 to 2. With 0.3 here and at the base a sample of 2 mm reads 7 lower
(`docs/validation.md`); without any the sample slides off the tip's edge in jumps."""
FORCE_TOLERANCE_N = 1e-4
"""Accuracy of the force at equilibrium [N]."""
FOOT_STARTS_MM = 1.0
"""Distance from the axis that separates the points that touch the cone from those that touch the foot [mm]: assumed."""
DEPTH_TOLERANCE_MM = 1e-4
"""Accuracy of the depth of equilibrium [mm]: 0.004 units of S."""
HOLE_RADIUS_MM = 1.5
"""Radius of the foot's hole; the standard allows diameters of 2.5 to 3.2 mm."""
PENETRATION_MM = 0.002
"""Largest penetration at any contact point [mm]."""
COARSER = 1.5
"""Factor of the spacing where a block without walls folds on the finer one: assumed."""
Core = Literal["resolved", "homogenised", "even"]
"""Walls and infill as cells of their own, one effective solid on the same planes, or on planes of even spacing."""
ON_A_TABLE = Mounting(base="table")
"""How ASTM D2240 has the sample: on a flat, hard, horizontal surface."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DurometerResult(SolveFigures):
    """Hardness of a block, as `magicsim press durometer` reports it."""

    shore_a: float
    """Hardness S, 0 to 100."""
    force_n: float
    """Force of the cone at equilibrium [N]."""
    depth_mm: float
    """How far the cone sticks out of the foot there [mm]."""
    height_mm: float
    """Height of the sample [mm]."""
    unknowns: int
    """Displacement unknowns."""
    walls: Walls
    """Whether walls and infill below the cone are cells of their own, one effective solid, or not there."""
    spacing_mm: float
    """Largest node spacing that was asked for below the cone [mm]."""
    seconds: float
    """Wall time of lattice and solve, compilation excluded [s]."""


def durometer(
    design: ElastomerDesign,
    *,
    spacing_mm: float = SPACING_MM,
    friction: float = FRICTION,
    hole_radius_mm: float | None = HOLE_RADIUS_MM,
    place: Place = "cell",
    walls: Literal["resolved", "homogenised"] = "resolved",
    mounting: Mounting = ON_A_TABLE,
    step_mm: float = STEP_MM,
    force_tolerance_n: float = FORCE_TOLERANCE_N,
    progress: Progress | None = None,
    told: Told = on_stderr,
) -> DurometerResult:
    """Shore A hardness of a block.

    Where no equilibrium is found with walls of their own below the cone, as on thin samples that are pressed by most of
    their height, the core is one effective solid; where a soft block without walls folds below the cone's edge, its
    nodes are `COARSER` times as far apart. The result says so.

    Args:
        design: The block; `lattice.spacing_mm` counts where it is finer than `spacing_mm`.
        spacing_mm: Node spacing under the cone [mm].
        friction: Coulomb's coefficient between tool and sample.
        hole_radius_mm: Of the presser foot's hole [mm]; None leaves the foot out.
        place: Where the cone presses on a block with a grid; near its middle.
        walls: Whether walls and infill below the cone are cells of their own, where that has an equilibrium, or one
            effective solid from the start, on planes that do not follow the walls and in the middle of the face, which
            is several times quicker.
        mounting: What holds the sample from below.
        step_mm: Motion of the cone in one load step [mm].
        force_tolerance_n: Accuracy of the force at equilibrium [N].
        progress: Told after every load step how far the cone is out of the foot, how far it can be [both in
            micrometres], and the forces.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        ConfigError: A number is not allowed, or the face is a height map.
        GeometryError: The design cannot be built.
        ConvergenceError: No valid equilibrium was found; thin and soft samples are pressed almost through.
    """
    check_friction(friction)
    check_number("spacing_mm", spacing_mm, *SPACINGS_MM)
    check_number("step_mm", step_mm, LEAST_STEP_MM, EXTENSION_MM)
    if hole_radius_mm is not None:
        check_number("hole_radius_mm", hole_radius_mm, SHAFT_RADIUS_MM, FOOT_RADIUS_MM)
    if isinstance(design.face, HeightMap):
        raise ConfigError("design.face of kind 'height_map' is not allowed: a durometer presses a plane or a crown")
    compile_kernels()
    design = design.mounted(mounting)
    start = time.perf_counter()
    spacing_mm = min(spacing_mm, design.lattice.spacing_mm or spacing_mm)
    attempts: list[tuple[Core, float]] = [("resolved", spacing_mm)]
    if walls == "homogenised":
        attempts = [("even", spacing_mm)]
    elif design.has_grid:
        attempts.append(("homogenised", spacing_mm))
    else:
        attempts.append(("resolved", COARSER * spacing_mm))
    with waiting("pressing the cone", told if progress is None else unheard) as share:
        for core, spacing in attempts:
            test = DurometerTest(
                design, core, spacing_mm=spacing, friction=friction, hole_radius_mm=hole_radius_mm, place=place
            )
            try:
                depth, state = test.equilibrium(step_mm, force_tolerance_n, progress or share)
                break
            except ConvergenceError as error:
                if (core, spacing) == attempts[-1]:
                    raise
                LOGGER.info("no equilibrium with a %s core at %g mm: %s", core, spacing, error)
    return DurometerResult(
        shore_a=100 * (1 - depth / EXTENSION_MM),
        force_n=test.cone_force_n(state),
        depth_mm=depth,
        height_mm=design.height_mm,
        max_penetration_mm=state.max_penetration_mm,
        min_jacobian=state.min_jacobian,
        force_balance=state.force_balance,
        iterations=test.iterations,
        unknowns=state.unknowns,
        walls="none" if not design.has_grid else "resolved" if core == "resolved" else "homogenised",
        spacing_mm=spacing,
        seconds=time.perf_counter() - start,
    )


def spring_force_n(depth_mm: float) -> float:
    """Force of the instrument's spring when the cone sticks out by a depth [N]."""
    return SPRING_N[0] + SPRING_N[1] * 100 * (1 - depth_mm / EXTENSION_MM)


def quarter_lattice(design: ElastomerDesign, place_mm: tuple[float, float], spacing_mm: float, core: Core) -> Lattice:
    """A quarter of the sample, fine below the cone."""
    spot = Zone(low_mm=place_mm, high_mm=place_mm).grown(SHAFT_RADIUS_MM)
    if core == "even":
        return central_lattice(design, spot, spacing_mm=spacing_mm, is_quarter=True)
    return resolved_lattice(
        design, spot, margin_mm=MARGINS_MM[not design.has_grid], spacing_mm=spacing_mm, growth=GROWTH, mirrored=True,
        homogenised=core == "homogenised",
    )  # fmt: skip


class DurometerTest:
    """A sample on the table, ready to be pressed to any depth."""

    def __init__(
        self,
        design: ElastomerDesign,
        core: Core,
        *,
        spacing_mm: float,
        friction: float = FRICTION,
        hole_radius_mm: float | None = HOLE_RADIUS_MM,
        place: Place = "cell",
        failure: CoreFailure = WHOLE,
    ) -> None:
        """Prepares the sample; arguments are those of `durometer`, and how the core fails where it is one solid."""
        self._hole_radius_mm = hole_radius_mm
        self._place_mm = (0.0, 0.0) if core == "even" else symmetric_place(design, place)
        lattice = weakened(quarter_lattice(design, self._place_mm, spacing_mm, core), failure)
        self._solver = ContactSolver(
            lattice,
            core=CoreLaw.of(design, lattice, failure),
            friction=friction,
            tolerance_mm=PENETRATION_MM,
            point_spacing_mm=spacing_mm / 3,
        )
        self.iterations = 0

    def pressed(self, depth_mm: float, previous: Deformation) -> Deformation:
        """The sample with the cone sticking out by a depth, from an earlier state."""
        tool = DurometerTool(depth_mm, self._hole_radius_mm)
        pose = Pose(position_mm=np.array([*self._place_mm, depth_mm]), rotation=np.eye(3))
        state = self._solver.solve(Indenter(shape=tool, pose=pose), previous)
        self.iterations += state.iterations
        return state

    def cone_force_n(self, state: Deformation) -> float:
        """Force on the cone, without that on the foot [N]."""
        quarter = self._solver.force_within_n(state, self._place_mm, FOOT_STARTS_MM)
        return 4 * float(quarter[2])

    def equilibrium(self, step_mm: float, force_tolerance_n: float, progress: Progress) -> tuple[float, Deformation]:
        """Depth at which sample and spring push alike [mm], and the state there: by steps, then by false position."""

        def excess(depth: float, state: Deformation) -> float:
            force, spring = self.cone_force_n(state), spring_force_n(depth)
            progress(round(1000 * depth), round(1000 * EXTENSION_MM), f"cone {force:.2f} N, spring {spring:.2f} N")
            return force - spring

        low, below, high, state = 0.0, -spring_force_n(0.0), step_mm, Deformation.rest(self._solver.lattice)
        while (above := excess(high, pressed := self.pressed(high, state))) < 0:
            if high >= EXTENSION_MM:  # softer than the scale
                return high, pressed
            low, below, high, state = high, above, min(high + step_mm, EXTENSION_MM), pressed
        while high - low > DEPTH_TOLERANCE_MM:
            middle = float(np.clip(high - above * (high - low) / (above - below), low + 1e-6, high - 1e-6))
            trial = self.pressed(middle, state)
            rest = excess(middle, trial)
            if abs(rest) < force_tolerance_n:
                return middle, trial
            if rest < 0:
                low, below, state = middle, rest, trial
            else:
                high, above, pressed = middle, rest, trial
        return high, pressed
