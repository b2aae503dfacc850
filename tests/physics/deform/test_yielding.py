"""Infill that flows: bounded stress, heat that is never negative, work that is conserved, and a dent."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from magicsim import load_design, load_object, press, press_limits
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation import bearing
from magicsim.deform.lattice.core_failure import CoreLaw, FailingCore
from magicsim.deform.lattice.structure import Lattice, TableTop, box_lattice
from magicsim.deform.lattice.yielding import FlowLaw
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConfigError
from magicsim.geometry.indenter import place_object

SHEAR_MPA, FLOWING_MPA, YIELD_SHEAR = 0.5, 0.2, 0.1
HEIGHT_MM, AREA_MM2 = 1.0, 1.0
PLATE, BALL = load_object("box:size_mm=6"), load_object("sphere:radius_mm=4")
BLOCK = ["footprint_mm=[10,10]", "lattice.spacing_mm=1.5", "lattice.cells_across=0"]


def layer() -> tuple[Lattice, FlowLaw]:
    """A layer between slippery plates, all of it able to flow: compression is uniform."""
    side = np.linspace(0, 1, 3)  # a quarter, whose planes of symmetry keep it from sliding away
    lattice = box_lattice((side, side, np.linspace(0, HEIGHT_MM, 3)), shear_modulus_mpa=SHEAR_MPA, lame_mpa=1000.0)
    law = FlowLaw(cells=np.arange(len(lattice.cells)), modulus_mpa=FLOWING_MPA, shear=YIELD_SHEAR)
    return replace(lattice, table=TableTop(friction=0.0, weight_mpa=0.0), is_mirrored=True), law


def compressed(depths_mm: Sequence[float]) -> Iterator[tuple[float, Deformation, FailingCore]]:
    lattice, flow = layer()
    law = CoreLaw(flow=flow)
    solver, state = ContactSolver(lattice, tolerance_mm=1e-5, core=law), None
    core = FailingCore(elasticity=solver._problem.elasticity, law=law)
    for depth in depths_mm:
        state = solver.solve(place_object(PLATE, gap_mm=-depth), state)
        yield depth, state, core


def axial_strain_at_yield() -> float:
    """Logarithmic strain e along a bar whose shear sqrt(exp(2 e) + 2 exp(-e) - 3) is that of yield; negative."""
    return float(brentq(lambda e: np.exp(2 * e) + 2 * np.exp(-e) - 3 - YIELD_SHEAR**2, -1.0, -1e-6))


def force_n(stretch: float, natural: float) -> float:
    """Of an incompressible bar: network of SHEAR - FLOWING, and one whose natural stretch is another one."""
    elastic = stretch / natural
    nominal = (SHEAR_MPA - FLOWING_MPA) * (stretch**2 - 1 / stretch) + FLOWING_MPA * (elastic**2 - 1 / elastic)
    return -AREA_MM2 * nominal / stretch


def free_height_mm(natural: float) -> float:
    """Height at which nothing presses any more; on the way up the network flows back where it is pulled too far."""
    pulled = float(brentq(lambda e: np.exp(2 * e) + 2 * np.exp(-e) - 3 - YIELD_SHEAR**2, 1e-6, 1.0))
    return float(brentq(lambda height: force_n(height, max(natural, height / np.exp(pulled))), 0.7, 1.0))


def test_layer_flows_as_a_bar_does_and_loses_the_plate_at_the_height_where_its_networks_agree():
    limit, deepest = axial_strain_at_yield(), 0.2
    natural = (1 - deepest) / np.exp(limit)
    dent = HEIGHT_MM - free_height_mm(natural)
    loading, unloading, last = (0.02, 0.04, 0.08, 0.14, deepest), (0.19, 0.18), (0.12, 0.09, dent + 0.01)
    found = {depth: float(state.force_n[2]) for depth, state, _ in compressed([*loading, *unloading, *last])}
    for depth in loading:
        flowed = (1 - depth) / np.exp(max(np.log(1 - depth), limit))
        assert found[depth] == pytest.approx(force_n(1 - depth, flowed), rel=6e-3), depth
    for depth in unloading:  # elastic: the natural stretch stays
        assert found[depth] == pytest.approx(force_n(1 - depth, natural), rel=1e-2), depth
    assert dent > 0.02
    slope = (found[0.09] - found[last[-1]]) / (0.09 - last[-1])
    assert last[-1] - found[last[-1]] / slope == pytest.approx(dent, abs=2e-3)


def test_heat_is_never_negative_and_work_is_what_is_stored_and_dissipated():
    """Half of the way up again; the work is the trapezoid of the force, which converges with the steps."""
    misfits = []
    for steps in (5, 10, 20):
        depths = np.linspace(0, 0.2, steps + 1)[1:].round(9)
        work, before, heat = 0.0, (0.0, 0.0), 0.0
        for depth, state, core in compressed([*depths, *depths[-2 : steps // 2 - 1 : -1]]):
            force, memory = float(state.force_n[2]), state.core
            assert memory is not None
            assert memory.dissipated_nmm >= heat
            work += (force + before[0]) / 2 * (depth - before[1])
            before, heat = (force, depth), memory.dissipated_nmm
            stored = core.stored_nmm(memory, core.elasticity.lattice.nodes_mm + state.displacements_mm)
        misfits.append(abs(work - heat - stored) / heat)
        assert heat > 0.4 * work, misfits
    assert misfits[-1] < 0.003
    assert misfits[0] > 4 * misfits[-1]


def test_infill_that_never_yields_presses_as_one_without_and_flow_is_softer_but_not_than_a_liquid():
    design = load_design("mini-magictac", BLOCK)
    liquid = load_design("mini-magictac", [*BLOCK, "materials.infill.shear_modulus_mpa=1.57e-5"])

    def at(block: Any, **options: Any) -> float:
        return press(block, BALL, depth_mm=0.8, **options).force_n[2]

    elastic, soft = at(design), at(liquid)
    never, flows, liquefied = (at(design, infill_yield_mpa=each) for each in (5.0, 0.003, 1e-5))
    assert never == pytest.approx(elastic, rel=1e-3)  # other steps on the way
    assert liquefied < flows < 0.999 * never
    assert liquefied == pytest.approx(soft, rel=0.05)


def test_press_that_is_released_leaves_a_dent_and_says_what_it_took():
    found = press(load_design("mini-magictac", BLOCK), BALL, depth_mm=0.8, infill_yield_mpa=0.003, release=True)
    pressed, *_, released = found.history
    assert pressed.dissipated_nmm > 0
    assert released.force_n == (0.0, 0.0, 0.0)
    assert 1e-3 < released.dent_mm < 0.1 * pressed.dent_mm
    assert released.dissipated_nmm >= pressed.dissipated_nmm
    assert {"dissipated_nmm", "dent_mm"} <= set(found.as_dict()["history"][0])
    plain = press(load_design("mini-magictac", BLOCK), BALL, depth_mm=0.2)
    assert not {"dissipated_nmm", "dent_mm"} & set(plain.as_dict()["history"][0])


def test_skin_of_a_block_whose_infill_flows_is_found_with_less_force(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(bearing, "FINEST_MM", 0.5)
    weak = [*BLOCK, "limits.elongation_at_break=[0.08,0.1]", "limits.tensile_strength_mpa=[9,9]"]
    dome = load_object("domed_cylinder:radius_mm=2")
    elastic, flows = (
        press_limits(load_design("mini-magictac", weak), dome, depth_mm=0.8, infill_yield_mpa=each).first("tear", 0)
        for each in (None, 1e-4)
    )
    assert flows.force_n < elastic.force_n


@pytest.mark.parametrize(
    ("design", "options", "named"),
    [
        (
            "uniform-block",
            {"infill_yield_mpa": 0.01},
            "infill_yield_mpa = 0.01 is not allowed for a block",
        ),
        (
            "mini-magictac",
            {"infill_yield_mpa": 0.0},
            "infill_yield_mpa = 0 is not allowed: must be",
        ),
        ("mini-magictac", {"release": True}, "release is not allowed without infill_yield_mpa or wall_tear"),
        ("mini-magictac-rate", {"infill_yield_mpa": 0.01, "speed_mm_s": 1.0}, "not allowed with speed_mm_s"),
    ],
)
def test_flow_that_cannot_be_is_refused(design: str, options: dict[str, Any], named: str):
    with pytest.raises(ConfigError) as error:
        press(load_design(design), BALL, depth_mm=0.1, **options)
    assert named in str(error.value)
