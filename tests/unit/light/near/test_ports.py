"""Ports of a face: every line has its own, and all together bring what an evenly bright half space does."""

import numpy as np
import pytest

from magicsim.light.backend import VARIANT, columns, mi
from magicsim.light.near.ports import Ports

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
PORTS = Ports.of((8.0, 6.0), 2.0, 3, 5)
EACH = 32


@pytest.fixture(scope="module")
def lines():
    return PORTS.lines(EACH, seed=4)


def test_every_line_runs_into_its_own_port_also_from_far_below(lines):
    places, ways = lines
    for away_mm in (0.0, 7.0):
        begin = places - away_mm * ways
        number, found = PORTS.met(mi.Ray3f(mi.Point3f(*columns(begin)), mi.Vector3f(*columns(ways))))
        assert np.array(found).all()
        # Single precision takes a line beside a border to the neighbour.
        assert (np.array(number) == PORTS.owners(EACH)).mean() > 0.999


def test_lines_that_miss_the_face_or_leave_it_run_into_none(lines):
    (places, ways), beside, above = lines, np.array([9.0, 0, 0]), np.array([0, 0, 1.0])
    for begin, way in ((places + beside, ways), (places, -ways), (places + above, ways)):
        _, found = PORTS.met(mi.Ray3f(mi.Point3f(*columns(begin)), mi.Vector3f(*columns(way))))
        assert not np.array(found).any()


def test_ports_are_even_in_place_and_in_projected_solid_angle(lines):
    places, ways = lines
    assert PORTS.count == 4 * 3 * 3 * 5
    assert PORTS.flux_mm2 * PORTS.count == pytest.approx(np.pi * 8 * 6)
    np.testing.assert_allclose(np.linalg.norm(ways, axis=1), 1, rtol=1e-12)
    assert places[:, 0].mean() == pytest.approx(0, abs=0.02)
    # With the cosine's density the mean of the squared cosine is 1/2, and that of a direction's x is 0.
    assert (ways[:, 2] ** 2).mean() == pytest.approx(0.5, abs=0.01)
    assert ways[:, :2].mean(0) == pytest.approx([0, 0], abs=0.01)
