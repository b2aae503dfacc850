"""Cells as printed: closed, as large as round edges say; uneven walls, waves and missing walls where they are due."""

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.geometry.design import load_design
from magicsim.geometry.elastomer import build_elastomer
from magicsim.geometry.files.export import export_design
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.printed_cells import FACET_TOLERANCE, WHOLE, cell_mesh, cell_volume_mm3

EDGES = np.array([0.8, 0.9, 1.0])


@pytest.mark.parametrize("radius_mm", [0.0, 0.05, 0.3])
@pytest.mark.parametrize("parts", [2, 3])
def test_a_cell_is_closed_and_has_the_volume_of_round_edges(radius_mm, parts):
    cell = cell_mesh(EDGES, parts, radius_mm)
    assert cell.is_watertight()
    assert cell.volume_mm3() == pytest.approx(cell_volume_mm3(EDGES, radius_mm), rel=FACET_TOLERANCE)
    np.testing.assert_allclose(np.ptp(cell.vertices, axis=0), EDGES, rtol=1e-6)


def test_edges_and_corners_stay_near_the_round():
    radius = 0.2
    places = np.abs(cell_mesh(EDGES, 2, radius).vertices)
    beyond = np.linalg.norm(np.maximum(places - (EDGES / 2 - radius), 0), axis=1)
    assert beyond.min() == pytest.approx(radius)
    assert beyond.max() < 1.16 * radius  # a sharp corner would be 1.73 away


def test_fillets_are_off_by_default_and_bounded():
    drawn = build_elastomer(load_design("mini-magictac", ["footprint_mm=[8,9]"]))
    assert drawn.infill.volume_mm3() == pytest.approx(drawn.grid.infill_volume_mm3)
    with pytest.raises(ConfigError, match=r"crossing_radius_mm = 0\.45 is not allowed.*must be at most 0\.4 cell_mm"):
        load_design("mini-magictac", ["unevenness.crossing_radius_mm=0.45"])


SMALL = ("footprint_mm=[12, 14]",)


def built(*settings: str):
    return build_elastomer(load_design("mini-magictac", [*SMALL, *settings]))


@pytest.fixture(scope="module")
def torn():
    return built("unevenness.torn_share=0.05", "unevenness.seed=3")


def walls(grid):
    counts = np.array(grid.counts)
    return int(sum((counts[axis] - 1) * counts.prod() // counts[axis] for axis in range(3)))


def mesh(elastomer, faces):
    """A mesh of the infill without its collapsed triangles."""
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])
    return SurfaceMesh(vertices=elastomer.infill.vertices, faces=faces[whole])


def test_no_wall_is_missing_by_default():
    assert built().fused is None


def test_as_many_walls_are_missing_as_asked_for_and_no_cell_lacks_two(torn):
    assert len(torn.fused.pairs) == round(0.05 * walls(torn.grid))
    assert len(np.unique(torn.fused.pairs)) == torn.fused.pairs.size
    steps = np.unique(torn.fused.pairs[:, 1] - torn.fused.pairs[:, 0])
    assert steps.tolist() == np.cumprod([1, *torn.grid.counts[:2]]).tolist()


def test_fused_cells_are_closed_and_hold_the_missing_walls(torn):
    fused = mesh(torn, torn.fused.without_membranes)
    assert fused.is_watertight()
    below, above = torn.fused.pairs.T
    axis = np.searchsorted(np.cumprod([1, *torn.grid.counts[:2]]), above - below)
    cell, pitch = torn.grid.cell_mm, torn.grid.pitch_mm
    added = sum((pitch[a] - cell[a]) * np.prod(np.delete(cell, a)) for a in axis)
    assert fused.volume_mm3() == pytest.approx(torn.grid.infill_volume_mm3 + added, rel=1e-9)


def test_every_cell_is_closed_by_its_membrane(torn):
    per_cell = torn.triangles_per_cell
    for cell in torn.fused.pairs.ravel():
        own = torn.fused.closed[cell * per_cell : (cell + 1) * per_cell]
        _, places = np.unique(own, return_inverse=True)
        vertices = torn.infill.vertices[np.unique(own)]
        assert SurfaceMesh(vertices=vertices, faces=places.reshape(-1, 3).astype(np.int32)).is_watertight()


def test_membranes_stand_in_the_missing_walls_and_tell_the_cell_behind(torn):
    per_cell = torn.triangles_per_cell
    membrane = np.flatnonzero(torn.fused.beyond != WHOLE)
    found = np.unique(np.stack([membrane // per_cell, torn.fused.beyond[membrane]], 1), axis=0)
    np.testing.assert_array_equal(found, torn.fused.pairs[np.argsort(torn.fused.pairs[:, 0])])
    assert len(membrane) == len(torn.fused.pairs) * per_cell / 6
    corners = torn.infill.vertices[torn.fused.faces[membrane]]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    below, above = torn.fused.pairs.T
    axis = np.searchsorted(np.cumprod([1, *torn.grid.counts[:2]]), above - below)
    assert area == pytest.approx(sum(np.prod(np.delete(torn.grid.cell_mm, a)) for a in axis))


def test_vertices_of_a_torn_print_are_those_of_the_whole_one(torn):
    np.testing.assert_array_equal(torn.infill.vertices, built().infill.vertices)
    np.testing.assert_array_equal(torn.infill.faces, built().infill.faces)


def test_each_seed_lacks_other_walls(torn):
    same, other = (built("unevenness.torn_share=0.05", f"unevenness.seed={seed}").fused.pairs for seed in (3, 4))
    np.testing.assert_array_equal(same, torn.fused.pairs)
    assert same.shape == other.shape
    assert (same != other).any()


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


def middles(elastomer):
    """Middles of the cells, shape (nz, ny, nx, 3) [mm]."""
    corners = cells(elastomer)
    nx, ny, nz = elastomer.grid.counts
    return ((corners.min(1) + corners.max(1)) / 2).reshape(nz, ny, nx, 3)


def test_pitch_has_a_scale_error_of_its_own_along_each_axis():
    drawn, found = middles(built()), middles(built("unevenness.pitch_scale=[1.02,0.99,1.0]"))
    np.testing.assert_allclose(np.diff(found[0, 0, :, 0]), 1.02 * np.diff(drawn[0, 0, :, 0]))
    np.testing.assert_allclose(np.diff(found[0, :, 0, 1]), 0.99 * np.diff(drawn[0, :, 0, 1]))
    np.testing.assert_array_equal(found[..., 2], drawn[..., 2])
    np.testing.assert_allclose(found.mean((0, 1, 2)), drawn.mean((0, 1, 2)), atol=1e-12)


def test_pitch_drifts_from_side_to_side_and_is_the_drawn_one_in_the_mean():
    elastomer = built("unevenness.pitch_drift=[0.04,0.0,0.0]")
    places, pitch = middles(elastomer)[0, 0, :, 0], elastomer.grid.pitch_mm[0]
    count = elastomer.grid.counts[0]
    steps = np.diff(places) / pitch - 1
    np.testing.assert_allclose(np.diff(steps), 0.04 / count, rtol=1e-6)
    assert steps.mean() == pytest.approx(0, abs=1e-12)


def test_skin_varies_smoothly_over_the_face_and_nothing_above_it_moves():
    drawn, found = built(), built("unevenness.skin_sd_mm=0.04", "unevenness.skin_length_mm=5")
    moved = (cells(found) - cells(drawn))[..., 2].reshape(*reversed(drawn.grid.counts), -1)
    is_low = np.isclose(cells(drawn)[0, :, 2], cells(drawn)[0, :, 2].min())
    assert (moved[1:] == 0).all()
    assert np.abs(moved[0][..., ~is_low]).max() <= np.abs(moved[0]).max() / 2 + 1e-12
    rise = moved[0][..., is_low]
    assert np.std(rise) == pytest.approx(0.04, rel=0.3)  # 12 x 14 mm hold few waves of 5 mm
    assert np.abs(rise).max() <= 3 * 0.04
    slope = np.ptp(rise, axis=-1) / drawn.grid.cell_mm[0]
    assert np.sqrt((slope**2).mean()) < 2 * np.sqrt(2) * np.pi * 0.04 / 5  # of a corner from the one across, at most


SHIFTED = (
    "unevenness.pitch_scale=[1.02,0.98,1.01]",
    "unevenness.pitch_drift=[0.02,-0.02,0.01]",
    "unevenness.skin_sd_mm=0.04",
)


def test_meshes_stay_closed_and_keep_their_volume():
    shifted = built(*SHIFTED)
    assert shifted.infill.is_watertight()
    assert shifted.infill.volume_mm3() == pytest.approx(1.02 * 0.98 * 1.01 * shifted.grid.infill_volume_mm3, rel=0.02)
    found = built("unevenness.wall_sd_mm=0.015", "unevenness.wave_sd_mm=0.05")
    assert found.infill.is_watertight()
    assert found.infill.volume_mm3() == pytest.approx(found.grid.infill_volume_mm3, rel=0.01)


def test_widest_waves_leave_all_cells_inside_the_block():
    found = built("unevenness.wave_sd_mm=0.2")
    low, high = found.body.vertices.min(0), found.body.vertices.max(0)
    assert (found.infill.vertices > low).all()
    assert (found.infill.vertices < high).all()


def test_each_seed_is_a_print_of_its_own():
    one, same, other = (cells(built("unevenness.wave_sd_mm=0.02", f"unevenness.seed={seed}")) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()


def test_what_is_printed_is_the_drawing(tmp_path):
    designs = [load_design("mini-magictac", [*SMALL, *more]) for more in ((), ("unevenness.wave_sd_mm=0.05", *SHIFTED))]
    for name, design in zip("ab", designs, strict=True):
        export_design(design, tmp_path / f"{name}.glb")
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("unevenness.torn_share=0.2", "must be a number of at least 0 and at most 0.1"),
        ("unevenness={torn_share=0.01,crossing_radius_mm=0.1}", "one of them must be 0"),
        ("unevenness.wall_sd_mm=0.02", "wall_mm - 3 wall_sd_mm must be at least 0.05 mm"),
        ("unevenness={wave_sd_mm=0.4,wave_length_mm=3}", "must be at most a tenth of it"),
        ("unevenness.wave_sd_mm=0.25", "must be at most 0.2, or cells would pass through the skin"),
        (
            "unevenness={skin_sd_mm=0.06,skin_length_mm=0.5}",
            "skin_sd_mm = 0.06 is not allowed with skin_length_mm = 0.5",
        ),
        ("unevenness.skin_sd_mm=0.1", "must be at most 0.0667"),
        ("unevenness.pitch_scale=[1.0,1.08,1.0]", "mm into the skin along y: must be at most 0.5 skin_mm"),
        ("unevenness.pitch_scale=[1.2,1.0,1.0]", "less than or equal to 1.1"),
    ],
)
def test_prints_that_cannot_be_are_one_line(setting, message):
    with pytest.raises(ConfigError, match=message) as told:
        load_design("mini-magictac", [setting])
    assert "\n" not in str(told.value)
