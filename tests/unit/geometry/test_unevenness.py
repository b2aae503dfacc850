"""Uneven prints: spreads as asked for, closed meshes, walls that bend together, and nothing at all by default."""

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.geometry.design import load_design
from magicsim.geometry.elastomer import build_elastomer
from magicsim.geometry.files.export import export_design

SMALL = ("footprint_mm=[12, 14]",)


def built(*settings: str):
    return build_elastomer(load_design("mini-magictac", [*SMALL, *settings]))


def cells(elastomer):
    """Vertices by cell, shape (cells, vertices, 3) [mm]."""
    return elastomer.infill.vertices.reshape(elastomer.grid.cell_count, -1, 3)


def test_the_default_print_is_its_drawing():
    drawn = built()
    widths = np.ptp(cells(drawn), axis=1)
    np.testing.assert_allclose(widths, np.broadcast_to(drawn.grid.cell_mm, widths.shape), atol=1e-12)


def test_walls_spread_as_asked_for():
    found = built("unevenness.wall_sd_mm=0.015")
    nx, ny, nz = found.grid.counts
    sides = cells(found).reshape(nz, ny, nx, -1, 3)[..., 0]
    walls = sides[:, :, 1:].min(-1) - sides[:, :, :-1].max(-1)
    assert walls.mean() == pytest.approx(0.1, abs=0.001)
    assert np.std(walls) == pytest.approx(0.015 * 0.96, rel=0.05)  # normal values moved to two deviations have 0.96 sd
    assert walls.min() > 0.05


def test_waves_move_cells_and_keep_their_walls():
    drawn, found = built(), built("unevenness.wave_sd_mm=0.05")
    moved = cells(found) - cells(drawn)
    assert np.std(moved) == pytest.approx(0.05, rel=0.15)
    nx, ny, nz = found.grid.counts
    sides = cells(found).reshape(nz, ny, nx, -1, 3)
    lattice = cells(drawn).reshape(nz, ny, nx, -1, 3)
    right, left = lattice[0, 0, 0, :, 0].max(), lattice[0, 0, 1, :, 0].min()
    ours = sides[:, :, :-1][..., np.isclose(lattice[0, 0, 0, :, 0], right), 0]
    theirs = sides[:, :, 1:][..., np.isclose(lattice[0, 0, 1, :, 0], left), 0]
    assert np.std(theirs - ours) < 0.1 * 0.05


def test_meshes_stay_closed_and_keep_their_volume():
    found = built("unevenness.wall_sd_mm=0.015", "unevenness.wave_sd_mm=0.05")
    assert found.infill.is_watertight()
    assert found.infill.volume_mm3() == pytest.approx(found.grid.infill_volume_mm3, rel=0.01)


def test_each_seed_is_a_print_of_its_own():
    one, same, other = (cells(built("unevenness.wave_sd_mm=0.02", f"unevenness.seed={seed}")) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()


def test_what_is_printed_is_the_drawing(tmp_path):
    designs = [load_design("mini-magictac", [*SMALL, *more]) for more in ((), ("unevenness.wave_sd_mm=0.05",))]
    for name, design in zip("ab", designs, strict=True):
        export_design(design, tmp_path / f"{name}.glb")
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("unevenness.wall_sd_mm=0.02", "wall_mm - 3 wall_sd_mm must be at least 0.05 mm"),
        ("unevenness={wave_sd_mm=0.4,wave_length_mm=3}", "must be at most a tenth of it"),
    ],
)
def test_prints_that_cannot_be_are_one_line(setting, message):
    with pytest.raises(ConfigError, match=message) as told:
        load_design("mini-magictac", [setting])
    assert "\n" not in str(told.value)
