"""Objects sharper than the lattice can follow: more contact points than nodes, and still one quiet path."""

from dataclasses import replace

import numpy as np
import pytest
from laboratory.stress.cases import every_path
from laboratory.stress.grid import VALID, run_path

from magicsim.config.models import load_preset
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConvergenceError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

TOLERANCE_MM = 0.002


def path(what: str, friction: float, *places: tuple[float, float]) -> list[Deformation]:
    """The default design, its lattice as coarse for small objects, under one at gaps and positions along x [mm]."""
    design = load_preset(ElastomerDesign, "design", "mini-magictac", ["lattice.cells_across=0"])
    thing = parse_object(what)
    poses = [place_object(thing, gap_mm=gap, x_mm=x) for gap, x in places]
    solver = ContactSolver(
        build_lattice(design, zone=contact_zone(poses, design)),
        tolerance_mm=TOLERANCE_MM,
        friction=friction,
        point_spacing_mm=point_spacing_mm(thing.shape()),
    )
    states: list[Deformation] = []
    for pose in poses:
        states.append(solver.solve(pose, states[-1] if states else None))
    return states


PUNCH, BOX, CONE = "punch:radius_mm=3,edge_radius_mm=0.5", "box:size_mm=5", "cone:half_angle_deg=30,tip_radius_mm=0.25"
QUICK = [(PUNCH, 0.8), (BOX, 0.8), (CONE, 0.0)]
OTHERS = [(PUNCH, 0.0), (BOX, 0.0), (CONE, 0.8)]
OTHERS += [
    (what, f) for what in ("dots:radius_mm=0.2,spacing_mm=0.8", "lines:width_mm=0.5,spacing_mm=1") for f in (0.0, 0.8)
]


@pytest.mark.parametrize(
    ("what", "friction"), [*QUICK, *(pytest.param(*each, marks=pytest.mark.slow) for each in OTHERS)]
)
def test_pressed_and_moved_along_without_a_shorter_step(what: str, friction: float) -> None:
    states = path(what, friction, (-0.3, 0.0), (-0.6, 0.0), (-0.9, 0.0), (-0.9, 0.3))
    pressed, moved = states[2:]
    forces = [state.force_n[2] for state in states[:3]]
    assert np.diff(forces).min() > 0
    assert sum(state.cutbacks + state.restarts for state in states) == 0
    assert max(state.max_penetration_mm for state in states) <= TOLERANCE_MM
    # Nodes are 0.9 mm apart: how hard a tip of a quarter millimetre presses depends on where between them it stands.
    assert moved.force_n[2] == pytest.approx(pressed.force_n[2], rel=0.2 if what.startswith("cone") else 0.1)
    if friction > 0:
        assert 0.02 < moved.force_n[0] / moved.force_n[2] < friction


def test_a_rounded_punch_slides_without_friction() -> None:
    """Edges sharper than the lattice would be held back by its nodes; these are half as wide as its spacing."""
    (moved,) = path("punch:radius_mm=3,edge_radius_mm=0.5", 0.0, (-0.9, 0.0), (-0.9, 0.3))[1:]
    assert abs(moved.force_n[0]) < 0.02 * moved.force_n[2]


def test_a_ball_deeper_than_its_diameter_still_presses() -> None:
    near, deep = path("sphere:radius_mm=0.5", 0.0, (-0.8, 0.0), (-1.4, 0.0))
    assert deep.force_n[2] > 1.5 * near.force_n[2]


@pytest.mark.slow
def test_a_path_that_pierces_the_face_in_usual_steps_is_solved() -> None:
    """A ball of 0.5 mm pressed 1.8 mm into a soft block that keeps its volume."""
    soft = (path for path in every_path() if path.label == "sphere 0.5 mm" and path.contrast == 1.0)
    (chosen,) = (path for path in soft if path.poisson_ratio == 0.499999)
    rows = list(run_path(replace(chosen, stages=chosen.stages[:2])))
    assert [row.outcome for row in rows] == [VALID, VALID]


def test_a_ball_much_deeper_than_its_diameter_is_refused_at_once() -> None:
    with pytest.raises(ConvergenceError, match=r"pressed 4.5 mm deep and measures 1 mm.* at least 1.8 mm"):
        path("sphere:radius_mm=0.5", 0.0, (-4.5, 0.0))
