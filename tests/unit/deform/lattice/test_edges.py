"""Where an object's edges press, and how close planes lie there."""

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.lattice.edges import Edges
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

DESIGN = load_preset(ElastomerDesign, "design", "mini-magictac", [])


def edges_of(what: str, *places: tuple[float, float]) -> Edges | None:
    poses = [place_object(parse_object(what), gap_mm=-0.6, x_mm=x, y_mm=y) for x, y in places or ((0.0, 0.0),)]
    zone = contact_zone(poses, DESIGN)
    assert zone is not None
    return zone.edges


def lattice_of(what: str, *overrides: str) -> Lattice:
    design = load_preset(ElastomerDesign, "design", "mini-magictac", list(overrides))
    return build_lattice(design, zone=contact_zone([place_object(parse_object(what), gap_mm=-0.6)], design))


def test_rim_of_a_punch_is_found_all_around() -> None:
    edges = edges_of("punch:radius_mm=3")
    assert edges is not None
    np.testing.assert_allclose(np.hypot(*edges.low_mm.T), 2.95, atol=0.06)
    np.testing.assert_allclose(np.hypot(*edges.across.T), 1.0, atol=1e-6)
    angles = np.arctan2(edges.low_mm[:, 1], edges.low_mm[:, 0])
    assert np.diff(np.sort(angles)).max() < 0.1


@pytest.mark.parametrize(
    "what",
    [
        "sphere:radius_mm=4", "sphere:radius_mm=0.3", "domed_cylinder:radius_mm=2", "cone:half_angle_deg=30",
        "dots:radius_mm=0.3,spacing_mm=1,size_mm=4", "lines:width_mm=0.4,spacing_mm=1,size_mm=4",
        "cylinder:radius_mm=5,length_mm=60,axis=x",
    ],
)  # fmt: skip
def test_round_and_narrow_objects_have_none(what: str) -> None:
    assert edges_of(what) is None


def test_sheared_edges_cover_their_way() -> None:
    edges = edges_of("box:size_mm=4", (0.0, 0.0), (1.0, 0.0))
    assert edges is not None
    np.testing.assert_allclose(edges.high_mm[:, 0] - edges.low_mm[:, 0], 1.0)
    np.testing.assert_allclose(edges.high_mm[:, 1] - edges.low_mm[:, 1], 0.0, atol=1e-12)


def test_planes_crowd_at_the_sides_of_a_box_and_nowhere_else() -> None:
    coarse, fine = lattice_of("box:size_mm=4", "lattice.edge_nodes=0"), lattice_of("box:size_mm=4")
    for axis in range(2):
        before, after = coarse.planes_mm[axis], fine.planes_mm[axis]
        assert np.isin(before, after).all()
        added = after[~np.isin(after, before)]
        assert len(added) > 0
        assert np.abs(np.abs(added) - 2.0).max() < 1.4
        middle = (after[1:] + after[:-1]) / 2
        assert np.diff(after)[np.abs(np.abs(middle) - 2).argmin()] < 0.2


def test_face_below_the_object_keeps_to_its_bound() -> None:
    for most in (150, 256):
        lattice = lattice_of("punch:radius_mm=3", f"lattice.edge_nodes={most}")
        below = [int((np.abs(planes) <= 3.3).sum()) for planes in lattice.planes_mm[:2]]
        assert below[0] * below[1] <= most


def test_lattices_of_round_objects_are_what_they_were() -> None:
    for own, other in zip(
        lattice_of("sphere:radius_mm=4").planes_mm, lattice_of("sphere:radius_mm=4", "lattice.edge_nodes=0").planes_mm,
        strict=True,
    ):  # fmt: skip
        np.testing.assert_array_equal(own, other)
