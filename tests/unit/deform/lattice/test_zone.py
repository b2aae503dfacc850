"""Where contact can be, and planes that are fine there."""

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.lattice.zone import contact_zone, graded_planes
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

DESIGN = load_preset(ElastomerDesign, "design", "mini-magictac", [])
BALL = parse_object("sphere:radius_mm=4")


def test_zone_bounds_the_undeformed_overlap() -> None:
    zone = contact_zone([place_object(BALL, gap_mm=-1.0, x_mm=2.0)], DESIGN)
    assert zone is not None
    radius = np.sqrt(4**2 - 3**2)
    np.testing.assert_allclose([*zone.low_mm, *zone.high_mm], [2 - radius, -radius, 2 + radius, radius], atol=0.2)


def test_zone_of_a_path_covers_all_its_poses() -> None:
    zone = contact_zone([place_object(BALL, gap_mm=-0.5, y_mm=y) for y in (-3.0, 3.0)], DESIGN)
    assert zone is not None
    assert zone.low_mm[1] < -3.0 < 3.0 < zone.high_mm[1]


def test_no_zone_where_nothing_touches() -> None:
    assert contact_zone([place_object(BALL, gap_mm=0.5)], DESIGN) is None


def test_graded_planes_are_a_symmetric_subset_that_is_full_inside() -> None:
    planes = np.linspace(-12, 12, 49)
    graded = graded_planes(planes, -2.0, 2.0, 1.5, keep_mm=np.array([-11.5, 11.5]))
    assert set(graded.tolist()) <= set(planes.tolist())
    np.testing.assert_allclose(graded, -graded[::-1])
    np.testing.assert_allclose(np.diff(graded[(graded >= -2) & (graded <= 2)]), 0.5)
    assert {-12.0, -11.5, 11.5, 12.0} <= set(graded.tolist())
    assert len(graded) < 25


def test_growth_of_one_keeps_every_plane() -> None:
    planes = np.linspace(0, 6, 7)
    np.testing.assert_array_equal(graded_planes(planes, 0, 1, 1.0, keep_mm=np.array([])), planes)


def test_spacing_grows_by_about_the_ratio() -> None:
    graded = graded_planes(np.linspace(0, 40, 401), 0.0, 1.0, 1.6, keep_mm=np.array([]))
    ratio = np.diff(graded)[1:] / np.diff(graded)[:-1]
    assert (ratio[:-1] > 0.99).all()
    np.testing.assert_allclose(ratio[-5:-1], 1.6, rtol=0.1)


def test_graded_lattice_keeps_the_skin_and_its_stiffness() -> None:
    even = load_preset(ElastomerDesign, "design", "mini-magictac", ["lattice.cells_across_round=0"])
    zone = contact_zone([place_object(BALL, gap_mm=-1.0)], even)
    lattice, whole = build_lattice(even, zone=zone), build_lattice(even)
    assert len(lattice.cells) < len(whole.cells) / 1.7
    for each in (lattice, whole):
        assert each.sizes_mm[each.is_core].prod(1).sum() == pytest.approx(22.4 * 30.4 * 5.0)
    assert set(np.unique(lattice.shear_modulus_mpa)) == set(np.unique(whole.shear_modulus_mpa))


def finest_mm(what: str, depth_mm: float, *overrides: str) -> float:
    design = load_preset(ElastomerDesign, "design", "mini-magictac", list(overrides))
    zone = contact_zone([place_object(parse_object(what), gap_mm=-depth_mm)], design)
    return float(min(np.diff(planes).min() for planes in build_lattice(design, zone=zone).planes_mm[:2]))


def test_a_small_blunt_object_asks_for_a_finer_lattice() -> None:
    assert finest_mm("sphere:radius_mm=8", 1.0) > 0.7
    assert finest_mm("sphere:radius_mm=4", 1.0) < 0.45
    assert finest_mm("sphere:radius_mm=0.5", 1.0) < 0.31
    assert finest_mm("sphere:radius_mm=4", 0.05) < 0.3
    assert finest_mm("sphere:radius_mm=4", 1.0, "lattice.cells_across_round=0") > 0.7
    assert finest_mm("sphere:radius_mm=0.5", 1.0, "lattice.cells_across=8") < 0.16
    assert finest_mm("sphere:radius_mm=0.5", 1.0, "lattice.cells_across=0") > 0.7


def test_tips_and_textures_do_not() -> None:
    assert finest_mm("cone:half_angle_deg=30", 0.5) > 0.7
    assert finest_mm("dots:radius_mm=0.2,spacing_mm=0.8", 0.5) > 0.7


@pytest.mark.parametrize(
    ("what", "x_mm", "y_mm", "tilt_deg"),
    [
        ("box:size_mm=3", 0.0, 0.0, 0.0),
        ("box:size_mm=4", 1.3, 0.7, 0.0),
        ("punch:radius_mm=2", 1.3, 0.7, 0.0),
        ("punch:radius_mm=1", 0.05, 0.0, 3.0),
        ("cylinder:radius_mm=2,length_mm=8,axis=x", 1.3, 0.7, 0.0),
    ],
)
def test_mirror_image_has_the_mirror_image_of_the_planes(what: str, x_mm: float, y_mm: float, tilt_deg: float) -> None:
    def planes(sign: int) -> list[np.ndarray]:
        there = place_object(parse_object(what), gap_mm=-1.0, x_mm=sign * x_mm, y_mm=y_mm, tilt_y_deg=sign * tilt_deg)
        return list(build_lattice(DESIGN, zone=contact_zone([there], DESIGN)).planes_mm)

    here, there = planes(1), planes(-1)
    for own, mirrored in zip(here, [-there[0][::-1], *there[1:]], strict=True):
        np.testing.assert_allclose(own, mirrored, atol=1e-9)
