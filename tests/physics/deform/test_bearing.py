"""Where a print fails: stretch and stress of the skin against closed forms, and the onsets that follow from them."""

from dataclasses import replace

import numpy as np
import pytest

from magicsim import Bearing, load_design, load_object, press_limits
from magicsim.deform.indentation import bearing
from magicsim.deform.indentation.bearing import BearingPlace, onset
from magicsim.deform.lattice.structure import Lattice, TableTop, box_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.deform.strain import SkinCells
from magicsim.errors import ConfigError
from magicsim.geometry.indenter import place_object

from .test_touch_fields import UNIFORM, displaced

SHEAR_MPA, LAME_MPA = 0.5, 25.0
DOME = load_object("domed_cylinder:radius_mm=1")


def sheet(thickness_mm: float, cells: int) -> Lattice:
    """A square of 2 mm, of cubes."""
    layers = round(cells * thickness_mm / 2)
    side, height = np.linspace(-1, 1, cells + 1), np.linspace(0, thickness_mm, layers + 1)
    return box_lattice((side, side, height), shear_modulus_mpa=SHEAR_MPA, lame_mpa=LAME_MPA)


def strained(lattice: Lattice, places_mm: np.ndarray, pressure_mpa: float = 0.0) -> tuple[float, float]:
    state = displaced(lattice, places_mm)
    state = replace(state, pressure_mpa=np.full(len(lattice.cells), pressure_mpa))
    return SkinCells.of(UNIFORM, lattice).strained(state)


@pytest.mark.parametrize("stretch", [1.1, 2.0, 3.7])
def test_biaxial_stretch_carries_the_nominal_stress_of_a_neo_hookean_membrane(stretch: float):
    """It is mu (l - l^-5), Treloar 1975: the pressure is what leaves the sheet free across."""
    lattice = sheet(0.5, 8)
    places = lattice.nodes_mm * [stretch, stretch, stretch**-2]
    free = -SHEAR_MPA * (stretch**-4 - 1)
    assert strained(lattice, places, free) == pytest.approx((stretch, SHEAR_MPA * (stretch - stretch**-5)), rel=1e-9)


def test_stretch_of_a_sheet_draped_over_a_sphere_converges_with_the_square_of_the_cells():
    """Polar angles k r / R about a ball of radius R: the sheet's far side is stretched by k (1 + t / R) along them.

    Gauss points lie inside the cells, and their largest stretch converges with the cells only.
    """
    radius, thickness, more = 2.0, 0.5, 1.2
    exact = more * (1 + thickness / radius)
    errors: dict[str, list[float]] = {"sides": [], "points": []}
    for cells in (8, 16, 32):
        lattice = sheet(thickness, cells)
        x, y, z = lattice.nodes_mm.T
        reach = np.hypot(x, y)
        angle, across = more * reach / radius, (radius + z) / np.maximum(reach, 1e-12)
        places = np.stack([across * np.sin(angle) * x, across * np.sin(angle) * y, (radius + z) * np.cos(angle)], 1)
        places[reach == 0] = np.stack([x, y, radius + z], 1)[reach == 0]
        places[:, 2] *= -1  # the ball comes from below the face
        errors["sides"].append(abs(strained(lattice, places)[0] - exact))
        points = SkinCells.of(UNIFORM, lattice).fields(displaced(lattice, places))
        errors["points"].append(abs(points.stretch.max() - exact))
    slopes = {name: np.log2(np.array(each[:-1]) / each[1:]) for name, each in errors.items()}
    assert slopes["sides"].min() > 1.8
    assert slopes["points"].max() < 1.5
    assert errors["sides"][-1] < 2e-3 * exact


def test_block_that_is_squeezed_between_plates_is_stretched_aside_without_tension():
    """Slippery plates: l = h / (h - depth) along z, l^-1/2 aside, and no stress there: the pressure takes it away."""
    side = np.linspace(-1, 1, 5)
    lattice = box_lattice((side, side, np.linspace(0, 1, 5)), shear_modulus_mpa=SHEAR_MPA, lame_mpa=1000.0)
    lattice = replace(lattice, table=TableTop(friction=0.0, weight_mpa=0.0))
    plate = load_object("box:size_mm=6")
    state, skin = None, SkinCells.of(UNIFORM, lattice)
    for depth in (0.1, 0.2, 0.3):
        state = ContactSolver(lattice).solve(place_object(plate, gap_mm=-depth), state)
        stretch, stress = skin.strained(state)
        assert stretch == pytest.approx((1 - depth) ** -0.5, rel=5e-3)
        assert abs(stress) < 0.03 * SHEAR_MPA * (stretch - 1 / stretch)


def places(*stretches: float) -> list[BearingPlace]:
    """A press to depths of 1, 2, ... mm with forces of 2, 4, ... N."""
    return [
        BearingPlace(depth_mm=n, force_n=2.0 * n, skin_stretch=each, skin_stress_mpa=each - 1, infill_stress_mpa=None)
        for n, each in enumerate(stretches, start=1)
    ]


def test_strength_is_reached_between_two_depths_first_from_rest():
    def at(strength: float, by: str = "skin_stretch") -> tuple[float | None, float | None]:
        found = onset(places(2.0, 3.0, 2.5), "tear", by, strength)
        return found.depth_mm, found.force_n

    assert at(1.5) == (0.5, 1.0)
    assert at(2.25) == (1.25, 2.5)
    assert at(1.25, "skin_stress_mpa") == (1.25, 2.5)
    assert at(3.1) == (None, None)


def test_first_failure_of_each_end_of_the_strengths_bounds_the_interval():
    strengths = [("tear", "skin_stretch", 2.0), ("tear", "skin_stretch", 3.5), ("tear", "skin_stress_mpa", 1.2)]
    path = places(2.0, 3.0)
    found = Bearing(
        onsets=tuple(onset(path, *each) for each in [*strengths, ("tear", "skin_stress_mpa", 1.5)]),
        history=tuple(path), stopped="", spacing_mm=0.2, skin_layers=2, seconds=0.0,
    ).as_dict()  # fmt: skip
    assert found["tear_depth_mm"] == [1.0, 1.5]  # by stretch when all is weakest, by stress when all is strongest
    assert found["yield_depth_mm"] == [None, None]
    assert (found["recommended_depth_mm"], found["recommended_by"]) == (1.0, "skin_stretch")


WEAK = [
    "footprint_mm=[8,8]", "skin_mm=0.5", "core_mm=2.7", "limits.elongation_at_break=[0.1,0.15]",
    "limits.tensile_strength_mpa=[5,6]", "limits.infill_yield_mpa=[0.0016,0.0047]",
]  # fmt: skip


def test_press_stops_when_every_strength_is_passed_or_at_the_depth(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(bearing, "FINEST_MM", 0.5)
    found = press_limits(load_design("mini-magictac", WEAK), DOME, depth_mm=1.0)
    assert found.stopped == "depth_mm = 1 is reached"
    low, high = (found.first("tear", end) for end in (0, 1))
    assert low is not None
    assert high is not None
    assert low.by == high.by == "skin_stretch"
    assert 0 < low.depth_mm < high.depth_mm < 1
    assert 0 < low.force_n < high.force_n
    soon = press_limits(load_design("mini-magictac", [*WEAK, "limits.tensile_strength_mpa=[0.01,0.02]"]), DOME)
    assert soon.stopped == "every strength is passed"
    assert soon.first("tear", 1).by == "skin_stress_mpa"


@pytest.mark.parametrize(
    ("design", "settings", "depth_mm", "named"),
    [
        ("uniform-block", [], 1.0, "the design says no strength: limits needs one of limits.elongation_at_break, "),
        ("uniform-block", ["limits.infill_yield_mpa=[0.01,0.02]"], 1.0, "limits.infill_yield_mpa is not allowed for a"),
        ("mini-magictac", [], 0.0, "depth_mm = 0 is not allowed with limits: must be above 0"),
        ("mini-magictac", [], 9.0, "depth_mm = 9 is not allowed: must be 0 to 5.94 (90 % of the height)"),
    ],
)
def test_press_that_has_no_limits_is_refused(design: str, settings: list[str], depth_mm: float, named: str):
    with pytest.raises(ConfigError) as error:
        press_limits(load_design(design, settings), DOME, depth_mm=depth_mm)
    assert named in str(error.value)


def test_events_and_spacings_that_there_are_not_are_refused():
    design = load_design("mini-magictac")
    with pytest.raises(ConfigError, match=r"until = \['wall_tear'\] is not allowed: events are yield, tear"):
        press_limits(design, DOME, until=["wall_tear"])
    with pytest.raises(ConfigError, match="coarsening = 0 is not allowed: must be a number of at least"):
        press_limits(design, DOME, coarsening=0)


@pytest.mark.parametrize(
    ("setting", "named"),
    [
        ("limits.elongation_at_break=[3,2]", "elongation_at_break = [3, 2] is not allowed: must not fall"),
        ("limits.tensile_strength_mpa=[0,2]", "tensile_strength_mpa"),
    ],
)
def test_strengths_that_fall_or_are_none_are_refused(setting: str, named: str):
    with pytest.raises(ConfigError) as error:
        load_design("mini-magictac", [setting])
    assert named in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.slow
def test_stretch_and_stress_below_a_small_dome_converge_with_the_nodes(monkeypatch: pytest.MonkeyPatch):
    """A dome of 1 mm radius on a skin of 0.6 mm: at the usual spacing of 0.2 mm all is converged to 1 %."""
    design = load_design("mini-magictac", ["skin_mm=0.6", "footprint_mm=[12,12]"])
    ends = []
    for spacing in (0.3, 0.2, 0.15):
        monkeypatch.setattr(bearing, "bearing_spacing_mm", lambda *_, spacing=spacing: spacing)
        ends.append(press_limits(design, DOME, depth_mm=1.5).history[-1])
    for name in ("force_n", "skin_stretch", "skin_stress_mpa", "infill_stress_mpa"):
        coarse, usual, fine = (getattr(each, name) for each in ends)
        assert usual == pytest.approx(fine, rel=0.01), name
        assert abs(usual - fine) < max(0.5 * abs(coarse - fine), 5e-3 * fine), (name, coarse, usual, fine)
