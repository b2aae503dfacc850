"""What the detectors need of the lattice."""

import json

import pytest
from laboratory.light.lattice_verdicts import DEPTHS_MM, LatticeRow, measure_lattice
from laboratory.light.plots import plot_lattice
from PIL import Image


def test_plot_is_drawn_from_the_file(tmp_path) -> None:
    rows = [
        {"unknowns": unknowns, "depth_mm": depth, "force_n": depth / unknowns, "entropy": 3.0, "correlation": 0.5,
         "similarity": 0.9}
        for unknowns in (7000, 20000) for depth in DEPTHS_MM
    ]  # fmt: skip
    plot_lattice(json.loads(json.dumps({"kind": "lattice", "results": rows})), tmp_path / "plot.png")
    with Image.open(tmp_path / "plot.png") as plot:
        assert plot.size[0] > 300


@pytest.mark.slow
def test_finer_lattice_has_more_unknowns_and_is_softer() -> None:
    """Displacement elements approach the force from above; the detectors read a touch on either."""
    coarse, fine = (measure_lattice(spacing, 1.6, quick=True) for spacing in (1.0, 0.5))
    assert all(isinstance(row, LatticeRow) for row in coarse)
    for one, other in zip(coarse, fine, strict=True):
        assert one.unknowns < other.unknowns
        assert one.force_n > other.force_n > 0
    assert coarse[1].force_n > coarse[0].force_n
