"""Flat faces, edges and balls at the default settings, beside lattices that are finer."""

from dataclasses import replace

import pytest

from magicsim.config.models import load_preset
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.lattice.spot import QUARTERS, central_lattice
from magicsim.deform.lattice.structure import Lattice, build_lattice, lattice_on
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

DESIGN = load_preset(ElastomerDesign, "design", "mini-magictac", [])
DEPTH_MM = 0.6


def fine(lattice: Lattice, scale: float) -> Lattice:
    zone = lattice.zone
    assert zone is not None
    assert zone.edges is not None
    x, y, z = central_lattice(DESIGN, zone, spacing_mm=0.9, is_quarter=True).planes_mm
    edges = zone.edges
    planes = edges.split(x, 0, scale=scale), edges.split(y, 1, scale=scale), edges.split_depth(z, scale=scale)
    return replace(lattice_on(planes, DESIGN), zone=zone, is_mirrored=True)


@pytest.mark.slow
@pytest.mark.parametrize("what", ["box:size_mm=4", "box:size_mm=12x4.5x12,edge_radius_mm=0.3", "punch:radius_mm=3"])
def test_force_and_area_below_a_flat_face(what: str) -> None:
    pressed = place_object(parse_object(what), gap_mm=-DEPTH_MM)
    own = build_lattice(DESIGN, zone=contact_zone([pressed], DESIGN))
    spacing = point_spacing_mm(pressed.shape)
    found = ContactSolver(own, point_spacing_mm=spacing).solve(pressed)
    best = ContactSolver(fine(own, 0.5), point_spacing_mm=spacing).solve(pressed)
    assert found.force_n[2] == pytest.approx(QUARTERS * best.force_n[2], rel=0.02)
    assert found.contact_area_mm2 == pytest.approx(QUARTERS * best.contact_area_mm2, rel=0.1)


@pytest.mark.parametrize("radius_mm", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_area_below_a_ball(radius_mm: int) -> None:
    """A face whose nodes are almost half a radius apart tells the border of the contact to a seventh of the area."""
    pressed = place_object(parse_object(f"sphere:radius_mm={radius_mm}"), gap_mm=-1.0)
    zone = contact_zone([pressed], DESIGN)
    assert zone is not None
    found = ContactSolver(build_lattice(DESIGN, zone=zone)).solve(pressed)
    best = ContactSolver(central_lattice(DESIGN, zone, spacing_mm=0.3, is_quarter=True)).solve(pressed)
    assert found.contact_area_mm2 == pytest.approx(QUARTERS * best.contact_area_mm2, rel=0.15)
    assert found.force_n[2] == pytest.approx(QUARTERS * best.force_n[2], rel=0.07)
