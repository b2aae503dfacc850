import math
import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from magicsim.config.models import load_preset
from magicsim.errors import GeometryError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import MAX_CELL_DEVIATION, MAX_CELLS, CellGrid, lattice_planes, resolve_grid, split_count

from .designs import EXTREMES, design

SIZES = st.floats(2.5, 40.0, allow_nan=False)


def grid_of(**changes: object) -> CellGrid:
    grid = resolve_grid(design(**changes))
    assert grid is not None
    return grid


def test_default_preset_has_whole_cells_of_its_specified_size():
    block = load_preset(ElastomerDesign, "design", "mini-magictac")
    grid = resolve_grid(block)
    assert grid is not None
    # core 22.4 x 30.4 x 5.0 mm at a pitch of 0.9 mm
    assert grid.counts == (25, 34, 6)
    assert grid.pitch_mm == pytest.approx([22.4 / 25, 30.4 / 34, 5.0 / 6])
    assert grid.cell_mm == pytest.approx([22.4 / 25 - 0.1, 30.4 / 34 - 0.1, 5.0 / 6 - 0.1])
    assert grid.infill_volume_mm3 == pytest.approx(25 * 34 * 6 * np.prod(grid.cell_mm))


@given(x=SIZES, y=SIZES, core=st.floats(0.5, 15.0), cell=st.floats(0.3, 3.0), wall=st.floats(0.05, 0.5))
def test_resolved_grid_follows_the_specification_or_is_refused(
    x: float, y: float, core: float, cell: float, wall: float
):
    block = design(footprint_mm=(x, y), core_mm=core, cell_mm=cell, wall_mm=wall)
    cores = [x - 1.6, y - 1.6, core]
    counts = [max(1, round(size / (cell + wall))) for size in cores]
    cells = [size / count - wall for size, count in zip(cores, counts, strict=True)]
    worst = max(abs(edge / cell - 1) for edge in cells)
    if worst > MAX_CELL_DEVIATION + 1e-9 or math.prod(counts) > MAX_CELLS:
        with pytest.raises(GeometryError):
            resolve_grid(block)
    elif worst < MAX_CELL_DEVIATION - 1e-9:
        grid = resolve_grid(block)
        assert grid is not None
        assert grid.counts == tuple(counts)
        assert grid.cell_mm == pytest.approx(cells)
        assert grid.pitch_mm == pytest.approx([size / count for size, count in zip(cores, counts, strict=True)])


@pytest.mark.parametrize("changes", EXTREMES.values(), ids=EXTREMES.keys())
def test_skin_is_exact_on_every_side(changes: dict[str, object]):
    block = design(**changes)
    grid = grid_of(**changes)
    outer = [(-block.footprint_mm[0] / 2, block.footprint_mm[0] / 2)]
    outer += [(-block.footprint_mm[1] / 2, block.footprint_mm[1] / 2), (0.0, block.height_mm)]
    for axis, (low, high) in enumerate(outer):
        planes = grid.planes_mm(axis)
        assert planes[0] - low == pytest.approx(block.skin_mm, abs=1e-9)
        assert high - planes[-1] == pytest.approx(block.skin_mm, abs=1e-9)


def test_cells_are_centred_in_their_pitch_and_numbered_with_x_fastest():
    grid = grid_of()
    centres = grid.centres_mm()
    assert len(centres) == grid.cell_count
    assert centres[1] - centres[0] == pytest.approx([grid.pitch_mm[0], 0, 0])
    assert centres[grid.counts[0]] - centres[0] == pytest.approx([0, grid.pitch_mm[1], 0])
    assert centres[0] == pytest.approx([grid.planes_mm(axis)[:2].mean() for axis in range(3)])
    assert centres.mean(0) == pytest.approx([0, 0, 2.3])


def test_resolved_cell_up_to_15_percent_off_is_allowed_and_more_is_refused():
    # core 3 mm along z: three cells of c + 0.2 mm ask for 0.8 mm
    assert grid_of(core_mm=3 * (0.8 * 1.149 + 0.2)).counts[2] == 3
    with pytest.raises(GeometryError, match=r"resolves to .* along z .*15%"):
        grid_of(core_mm=3 * (0.8 * 1.151 + 0.2))


def test_core_too_low_for_one_cell_is_refused_with_the_sizes():
    with pytest.raises(GeometryError, match=r"no cell fits along z: the core is 0\.5 mm .* 1 mm"):
        grid_of(core_mm=0.5)


def test_footprint_without_a_core_is_refused():
    with pytest.raises(GeometryError, match="no cell fits along x"):
        grid_of(footprint_mm=(2.0, 8.0), skin_mm=1.5)


def test_more_cells_than_fit_in_memory_are_refused():
    with pytest.raises(GeometryError, match="too many"):
        grid_of(footprint_mm=(200.0, 200.0), core_mm=5.0, cell_mm=0.3, wall_mm=0.1)


def test_block_without_cells_has_no_grid():
    assert resolve_grid(design(cell_mm=0.0)) is None


@pytest.mark.parametrize("changes", EXTREMES.values(), ids=EXTREMES.keys())
def test_lattice_planes_hold_grid_planes_and_outer_faces_within_the_spacing(changes: dict[str, object]):
    block = design(**changes)
    grid = grid_of(**changes)
    ends = [block.footprint_mm[0] / 2, block.footprint_mm[1] / 2, block.height_mm]
    for axis, planes in enumerate(lattice_planes(block, grid)):
        assert planes[-1] == pytest.approx(ends[axis], abs=1e-12)
        assert planes[0] == pytest.approx(0.0 if axis == 2 else -ends[axis], abs=1e-12)
        spacing = block.lattice.spacing_mm or grid.pitch_mm[axis]
        assert all(0 < high - low <= spacing * 1.05 + 1e-9 for low, high in pairwise(planes))
        for plane in grid.planes_mm(axis):
            assert np.abs(planes - plane).min() < 1e-9


def test_lattice_without_a_grid_splits_the_block_evenly():
    planes = lattice_planes(design(cell_mm=0.0, lattice={"spacing_mm": 2.0}), None)
    assert planes[0] == pytest.approx([-3, -1, 1, 3])
    assert planes[1] == pytest.approx([-4, -2, 0, 2, 4])
    assert np.diff(planes[2]) == pytest.approx([4.6 / 3] * 3)


def test_lattice_without_a_grid_has_a_spacing_of_one_millimetre_by_default():
    assert np.diff(lattice_planes(design(cell_mm=0.0), None)[0]) == pytest.approx([1.0] * 6)


@pytest.mark.parametrize(("length_mm", "count"), [(0.4, 1), (1.0, 1), (1.049, 1), (1.06, 2), (2.04, 2), (2.06, 3)])
def test_interval_is_split_only_when_it_exceeds_the_spacing_by_five_percent(length_mm: float, count: int):
    assert split_count(length_mm, 1.0) == count


@pytest.mark.parametrize(
    "changes",
    [
        {"cell_mm": 2.9, "core_mm": 1.0},
        {"cell_mm": 2.5, "core_mm": 4.0, "wall_mm": 0.3},
        {"cell_mm": 0.8, "core_mm": 1.4, "wall_mm": 0.2},
    ],
)
def test_a_design_that_does_not_fit_is_answered_with_values_that_do(changes: dict[str, float]):
    design = load_preset(ElastomerDesign, "design", "mini-magictac").model_copy(update=changes)
    with pytest.raises(GeometryError) as refusal:
        resolve_grid(design)
    proposed = dict(re.findall(r"(\w+_mm) = ([\d.]+)", str(refusal.value).partition("what fits: ")[2]))
    assert proposed
    for name, value in proposed.items():
        assert resolve_grid(design.model_copy(update={name: float(value)})) is not None
        nearer = [
            float(value) + step * 0.02 for step in (1, -1) if step * (changes.get(name, 0.1) - float(value)) > 0.03
        ]
        for closer in nearer:  # no value closer to the one asked for fits
            with pytest.raises(GeometryError):
                resolve_grid(design.model_copy(update={name: closer}))


def test_cell_of_just_85_percent_is_allowed():
    # core 3 mm along z: three walls and three cells of 1 mm ask for 1.15 mm each
    assert grid_of(core_mm=3.0, cell_mm=1.0, wall_mm=0.15, footprint_mm=(23, 23)).cell_mm[2] == pytest.approx(0.85)
