from pathlib import Path

import pytest
import trimesh

from magicsim.errors import GeometryError, OutputError
from magicsim.geometry.export import export_design

from .designs import design

BLOCK_MM3 = 6 * 8 * 4.6
# Default cells of `design`: 4 x 6 x 3 in a core of 4.4 x 6.4 x 3 mm, walls of 0.2 mm
INFILL_MM3 = 4 * 6 * 3 * (1.1 - 0.2) * (6.4 / 6 - 0.2) * 0.8


def read(path: Path) -> trimesh.Trimesh:
    mesh = trimesh.load_mesh(path)  # STL repeats vertices: loading merges them
    assert isinstance(mesh, trimesh.Trimesh)
    return mesh


def test_clear_part_is_the_block_with_its_cells_hollow(tmp_path: Path):
    done = export_design(design(), tmp_path / "block.stl")
    mesh = read(tmp_path / "block.stl")
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(BLOCK_MM3 - INFILL_MM3, rel=1e-5)
    assert done.volume_mm3 == pytest.approx(BLOCK_MM3 - INFILL_MM3)
    assert done.watertight
    # one outer surface and one cavity for each cell
    assert mesh.body_count == 1 + 4 * 6 * 3


def test_infill_stands_beside_the_clear_part(tmp_path: Path):
    done = export_design(design(), tmp_path / "block.stl")
    mesh = read(tmp_path / "block-infill.stl")
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(INFILL_MM3, rel=1e-5)
    assert done.infill_volume_mm3 == pytest.approx(INFILL_MM3)
    assert done.files == [str(tmp_path / "block.stl"), str(tmp_path / "block-infill.stl")]


def test_block_without_a_grid_is_one_file(tmp_path: Path):
    done = export_design(design(cell_mm=0.0), tmp_path / "new" / "plain.stl")
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["plain.stl"]
    assert read(tmp_path / "new" / "plain.stl").volume == pytest.approx(BLOCK_MM3, rel=1e-5)
    assert done.infill_volume_mm3 == 0


@pytest.mark.parametrize("name", ["block.obj", "block", "block.stl.gz", "block.3mfx"])
def test_name_of_another_format_is_refused_before_any_work(tmp_path: Path, name: str):
    with pytest.raises(OutputError, match=r"must end in \.stl"):
        export_design(design(), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_written_for_a_design_that_cannot_be_built(tmp_path: Path):
    with pytest.raises(GeometryError):
        export_design(design(core_mm=0.5), tmp_path / "block.stl")
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_left_when_one_of_two_parts_cannot_be_written(tmp_path: Path):
    (tmp_path / "block-infill.stl").mkdir()
    with pytest.raises(OutputError, match="is a folder"):
        export_design(design(), tmp_path / "block.stl")
    assert [path.name for path in tmp_path.iterdir()] == ["block-infill.stl"]


def test_folder_that_cannot_be_made_is_one_line(tmp_path: Path):
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(OutputError, match="cannot write"):
        export_design(design(), tmp_path / "taken" / "block.stl")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]
