"""Walls that tear and buckle: closed forms of a layer, heat that is what the block keeps less, and no healing."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from magicsim import load_design, load_object, press, press_curve
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.cell_kernels import wall_energy
from magicsim.deform.lattice.core_failure import CoreLaw, FailingCore
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.structure import Lattice, TableTop, box_lattice, build_lattice
from magicsim.deform.lattice.tearing import TearLaw
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConfigError, RenderError
from magicsim.geometry.indenter import place_object
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import timeline
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor

SHEAR_MPA, WALL_MPA, LEFT_MPA, HEIGHT_MM = 0.3, 0.2, 0.05, 1.0
STRETCH = 1.05
PLATE, BALL = load_object("box:size_mm=6"), load_object("sphere:radius_mm=2")
BLOCK = ["footprint_mm=[10,10]", "lattice.spacing_mm=1.0", "lattice.cells_across=0"]


def layer(*, walls: float, buckles_at: float | None = None) -> Lattice:
    """A layer between slippery plates with walls along it: compression is uniform."""
    side = np.linspace(0, 1, 3)
    box = box_lattice((side, side, np.linspace(0, HEIGHT_MM, 3)), shear_modulus_mpa=SHEAR_MPA, lame_mpa=1000.0)
    return replace(
        box, wall_modulus_mpa=np.full(len(box.cells), walls), wall_buckling_strain=buckles_at, is_mirrored=True,
        table=TableTop(friction=0.0, weight_mpa=0.0),
    )  # fmt: skip


def energy(height: float, *, shear: float, walls: float, rho: float) -> float:
    """Of an incompressible layer of unit volume, squeezed along z between slippery plates [N mm]."""
    fibres = wall_energy(height**2, rho)[0] + 2 * wall_energy(1 / height, rho)[0]
    return shear / 2 * (height**2 + 2 / height - 3) + walls * fibres


def force_n(height: float, **moduli: float) -> float:
    small = 1e-6
    return (energy(height - small, **moduli) - energy(height + small, **moduli)) / (2 * small)


def compressed(lattice: Lattice, depths: Sequence[float], law: CoreLaw | None = None) -> list[Deformation]:
    solver, states = ContactSolver(lattice, tolerance_mm=1e-5, core=law), list[Deformation]()
    for depth in depths:
        states.append(solver.solve(place_object(PLATE, gap_mm=-depth), states[-1] if states else None))
    return states


def height_mm(lattice: Lattice, state: Deformation) -> float:
    """Of the squeezed layer [mm]: a table gives way a little, which a depth does not tell."""
    z = (lattice.nodes_mm + state.displacements_mm)[:, 2]
    return float(z[-lattice.layer_nodes :].mean() - z[: lattice.layer_nodes].mean())


def tear_law(lattice: Lattice) -> CoreLaw:
    """One printed cell, whose walls tear at a stretch."""
    cells = np.arange(len(lattice.cells))
    return CoreLaw(tear=TearLaw(cells=cells, printed=np.zeros_like(cells), stretch=STRETCH, modulus_mpa=LEFT_MPA))


def test_layer_tears_where_its_stretch_across_says_and_keeps_what_is_left():
    whole = {"shear": SHEAR_MPA, "walls": WALL_MPA, "rho": SHEAR_MPA / 2 / WALL_MPA}
    left = {"shear": LEFT_MPA, "walls": 0.0, "rho": 1.0}
    lattice = layer(walls=WALL_MPA)
    tears = 1 - STRETCH**-2  # depth at which 1 / sqrt(height) is the stretch
    depths = [0.05, tears - 1e-3, tears + 1e-3, 0.15, 0.05]
    states = compressed(lattice, depths, tear_law(lattice))
    heights = [height_mm(lattice, state) for state in states]
    for height, state, moduli in zip(heights, states, [whole, whole, left, left, left], strict=True):
        assert float(state.force_n[2]) == pytest.approx(force_n(height, **moduli), rel=2e-3), height
    heat = [state.core.dissipated_nmm for state in states]
    lost = energy(heights[2], **whole) - energy(heights[2], **left)
    assert heat[:2] == [0.0, 0.0]
    assert heat[2] == pytest.approx(lost, rel=5e-3)  # the table's spring gives a little besides
    assert heat[2] == heat[3] == heat[4]  # it does not heal, and nothing is lost on the way back


def test_work_is_what_is_stored_and_what_became_heat():
    """The work is the trapezoid of the force, whose fall is in one step: it converges as the steps do."""
    lattice, misfits = layer(walls=WALL_MPA), []
    law = tear_law(lattice)
    core = FailingCore(elasticity=Elasticity.of(lattice), law=law)
    for steps in (10, 40):
        depths = np.linspace(0, 0.15, steps + 1)[1:]
        states = compressed(lattice, depths, law)
        work = float(np.trapezoid([0.0, *(float(each.force_n[2]) for each in states)], [0.0, *depths]))
        last = states[-1]
        stored = core.stored_nmm(last.core, lattice.nodes_mm + last.displacements_mm)
        misfits.append(abs(work - stored - last.core.dissipated_nmm) / last.core.dissipated_nmm)
    assert misfits[-1] < 0.05
    assert misfits[-1] < misfits[0] / 2


@pytest.mark.parametrize("strain", [0.05, 0.15])
def test_buckled_walls_carry_no_more_than_at_their_squeeze(strain: float):
    rho = min(SHEAR_MPA / 2 / WALL_MPA, ((1 - strain) ** -2 - 1) / 1.4)
    depths = [strain / 2, strain, 0.3]
    lattice = layer(walls=WALL_MPA, buckles_at=strain)
    buckled, firm = compressed(lattice, depths), compressed(layer(walls=WALL_MPA), depths)
    for state in buckled:
        height = height_mm(lattice, state)
        found = force_n(height, shear=SHEAR_MPA, walls=WALL_MPA, rho=rho)
        assert float(state.force_n[2]) == pytest.approx(found, rel=2e-3), height
    assert buckled[0].force_n[2] == pytest.approx(firm[0].force_n[2], rel=1e-6)  # not before
    assert buckled[2].force_n[2] < 0.97 * firm[2].force_n[2]


def test_stretch_of_a_printed_cell_is_that_of_its_walls_on_any_lattice():
    """Affine motion: stretched along a diagonal of the walls across z, which none of the edges is."""
    turn = np.array([[1, -1, 0], [1, 1, 0], [0, 0, np.sqrt(2)]]) / np.sqrt(2)
    motion = turn @ np.diag([1.5, 0.8, 1 / 1.2]) @ turn.T
    found = []
    for spacing in (2.0, 0.7):
        design = load_design("mini-magictac", ["footprint_mm=[10,10]", f"lattice.spacing_mm={spacing}"])
        lattice = build_lattice(design)
        law = TearLaw.of(design, lattice, 1.0)
        assert law is not None
        stretches = law.stretches(Elasticity.of(lattice), lattice.nodes_mm @ motion.T)
        np.testing.assert_allclose(stretches, 1.5, rtol=1e-9)
        found.append(len(stretches))
    assert found[0] == found[1]


def test_press_that_tears_is_softer_does_not_heal_and_says_so():
    design = load_design("mini-magictac", BLOCK)
    elastic, torn = (
        press_curve(design, BALL, [0.4, 0.8, 1.2], wall_tear_elongation=each, told=str.strip) for each in (None, 0.15)
    )
    assert torn.points[0].torn_cells == 0
    assert torn.forces_n[0, 2] == pytest.approx(elastic.forces_n[0, 2], rel=1e-3)
    assert torn.points[-1].torn_cells >= 1
    assert 0.3 * elastic.forces_n[-1, 2] < torn.forces_n[-1, 2] < 0.98 * elastic.forces_n[-1, 2]
    heat = [each.dissipated_nmm for each in torn.points]
    assert heat[0] == 0 < heat[-1]
    released = press(design, BALL, depth_mm=1.2, wall_tear_elongation=0.15, release=True).history
    assert released[-1].torn_cells == released[0].torn_cells
    assert released[-1].dent_mm < 1e-3  # nothing holds it but infill, which is elastic here


@pytest.mark.parametrize(
    ("design", "options", "named"),
    [
        ("uniform-block", {"wall_tear_elongation": 1.0}, "wall_tear_elongation = 1 is not allowed for a block without"),
        ("uniform-block", {"wall_buckling_strain": 0.1}, "wall_buckling_strain = 0.1 is not allowed for a block"),
        ("mini-magictac", {"wall_tear_elongation": 0.0}, "wall_tear_elongation = 0 is not allowed: must be"),
        ("mini-magictac", {"wall_buckling_strain": 0.5}, "wall_buckling_strain = 0.5 is not allowed: must be"),
        ("mini-magictac-rate", {"wall_tear_elongation": 1.0, "speed_mm_s": 1.0}, "not allowed with speed_mm_s"),
    ],
)
def test_walls_that_cannot_fail_so_are_refused(design: str, options: dict[str, float], named: str):
    with pytest.raises(ConfigError) as error:
        press(load_design(design), BALL, depth_mm=0.1, **options)
    assert named in str(error.value)


def test_scene_refuses_torn_walls_in_the_light_and_its_plan_names_them():
    keys = "keyframes=[{frame=0,gap_mm=-0.2},{frame=1,gap_mm=-1.2}]"
    settings = ["object={kind='sphere',radius_mm=2}", keys, *(f"design.{each}" for each in BLOCK)]
    scene = load_scene("pressed", [*settings, "contact.wall_tear_elongation=0.15", "contact.wall_buckling_strain=0.2"])
    kept, left_out = plan_scene(scene).kept, plan_scene(load_scene("pressed", settings)).left_out
    for decisions in (kept, left_out):
        assert {"buckling of walls", "tearing of walls"} <= {each.stage for each in decisions}
    sensor = Sensor.for_scene(scene)
    first, second = timeline(scene)
    light = sensor.deform(first, sensor.rest)
    with pytest.raises(RenderError, match=r"walls of \d+ printed cells have torn \(contact\.wall_tear"):
        sensor.deform(second, light)
