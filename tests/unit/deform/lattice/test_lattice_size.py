import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.lattice.zone import Zone, graded_planes
from magicsim.errors import GeometryError
from magicsim.geometry.design import ElastomerDesign

ZONE = Zone(low_mm=(-1.0, -1.0), high_mm=(1.0, 1.0), is_blunt=True)


@pytest.mark.parametrize(
    ("settings", "zone", "most"),
    [
        (["lattice.spacing_mm=0.1", "lattice.growth=1"], ZONE, 170_000),
        (["lattice.spacing_mm=0.1", "lattice.fine_depth=5", "lattice.margin=20"], ZONE, 170_000),
        (["lattice.spacing_mm=0.1", "footprint_mm=[200,200]"], None, 1_000_000),
    ],
)
def test_lattice_that_would_not_fit_into_memory_is_refused(settings: list[str], zone: Zone | None, most: int):
    design = load_preset(ElastomerDesign, "design", "uniform-block", settings)
    with pytest.raises(GeometryError, match=f"at most {most} are allowed: take a larger design.lattice.spacing_mm"):
        build_lattice(design, zone=zone)


def test_planes_of_a_large_block_spread_without_overflow():
    planes = np.linspace(0, 200, 2001)
    chosen = graded_planes(planes, 99.0, 101.0, 3.0, keep_mm=np.zeros(0))
    assert len(chosen) < 40
    assert np.diff(chosen).min() == pytest.approx(0.1)
