import sys
import zipfile
from pathlib import Path

import numpy as np
import pygltflib
import pytest
import trimesh

from geometry.designs import design
from magicsim.errors import GeometryError, OutputError
from magicsim.geometry.files.export import export_design
from magicsim.geometry.files.mesh_file import load_mesh

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


def test_file_beside_the_named_one_is_replaced_only_where_magicsim_wrote_it(tmp_path: Path):
    (tmp_path / "block-infill.stl").write_text("mine")
    with pytest.raises(OutputError, match=r"block-infill\.stl' would be replaced, and magicsim did not write it"):
        export_design(design(), tmp_path / "block.stl")
    assert (tmp_path / "block-infill.stl").read_text() == "mine"
    assert not (tmp_path / "block.stl").exists()
    (tmp_path / "block-infill.stl").unlink()
    export_design(design(), tmp_path / "block.stl")
    export_design(design(), tmp_path / "block.stl")


def test_folder_that_cannot_be_made_is_one_line(tmp_path: Path):
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(OutputError, match="cannot write"):
        export_design(design(), tmp_path / "taken" / "block.stl")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def read_glb(path: Path) -> dict[str, trimesh.Trimesh]:
    """Meshes of a GLB file by the name of their node, through its matrix [m], by another library than the writer."""
    file = pygltflib.GLTF2().load(str(path))
    assert file is not None
    blob = file.binary_blob()

    def rows(index: int, kind: str, width: int) -> np.ndarray:
        accessor = file.accessors[index]
        start = file.bufferViews[accessor.bufferView].byteOffset + (accessor.byteOffset or 0)
        return np.frombuffer(blob, kind, accessor.count * width, start).reshape(-1, width)

    meshes = {}
    for node in (file.nodes[index] for index in file.scenes[file.scene or 0].nodes):
        [primitive] = file.meshes[node.mesh].primitives
        matrix = np.array(node.matrix, dtype=float).reshape(4, 4).T  # column-major in the file
        vertices = rows(primitive.attributes.POSITION, "<f4", 3) @ matrix[:3, :3].T + matrix[:3, 3]
        meshes[node.name] = trimesh.Trimesh(vertices, rows(primitive.indices, "<u4", 1).reshape(-1, 3), process=False)
    return meshes


def test_3mf_holds_both_parts_by_name_in_mm_with_their_volumes(tmp_path: Path):
    done = export_design(design(), tmp_path / "block.3mf")
    scene = trimesh.load_scene(tmp_path / "block.3mf")
    assert scene.units == "millimeter"
    assert set(scene.geometry) == {"body", "infill"}
    assert all(mesh.is_watertight for mesh in scene.geometry.values())
    assert scene.geometry["body"].volume == pytest.approx(BLOCK_MM3 - INFILL_MM3, rel=1e-6)
    assert scene.geometry["infill"].volume == pytest.approx(INFILL_MM3, rel=1e-6)
    assert scene.bounds == pytest.approx(np.array([[-3, -4, 0], [3, 4, 4.6]]))
    assert done.volume_mm3 == pytest.approx(BLOCK_MM3 - INFILL_MM3)
    assert done.files == [str(tmp_path / "block.3mf")]


def test_3mf_names_a_material_for_each_part_and_groups_them_as_one_object(tmp_path: Path):
    export_design(design(), tmp_path / "block.3mf")
    with zipfile.ZipFile(tmp_path / "block.3mf") as archive:
        model = archive.read("3D/3dmodel.model").decode()
    assert model.count("<base name=") == 2
    assert model.count("<component ") == 2
    assert model.count("<item ") == 1


def test_glb_stands_upright_in_metres_with_the_volumes_of_both_parts(tmp_path: Path):
    done = export_design(design(), tmp_path / "block.glb")
    meshes = read_glb(tmp_path / "block.glb")
    assert set(meshes) == {"body", "infill"}
    assert all(mesh.is_watertight for mesh in meshes.values())
    assert meshes["body"].volume * 1e9 == pytest.approx(done.volume_mm3, rel=1e-5)
    assert meshes["infill"].volume * 1e9 == pytest.approx(INFILL_MM3, rel=1e-5)
    # the contact face (z = 0) looks down, and +y of the sensor points away from the viewer (-z)
    assert meshes["body"].bounds * 1e3 == pytest.approx(np.array([[-3, 0, -4], [3, 4.6, 4]]), abs=1e-5)


def test_glb_reads_back_as_an_object_of_this_program(tmp_path: Path):
    export_design(design(cell_mm=0.0), tmp_path / "plain.glb")
    assert set(read_glb(tmp_path / "plain.glb")) == {"body"}
    mesh = load_mesh(str(tmp_path / "plain.glb"), scale=1000.0).mesh()
    assert mesh.volume_mm3() == pytest.approx(BLOCK_MM3, rel=1e-5)


@pytest.mark.parametrize("suffix", [".stl", ".3mf", ".glb"])
def test_same_design_gives_the_same_bytes(tmp_path: Path, suffix: str):
    for folder in ("first", "second"):
        export_design(design(), tmp_path / folder / f"block{suffix}")
    first, second = ((tmp_path / folder / f"block{suffix}").read_bytes() for folder in ("first", "second"))
    assert first == second


def test_missing_3mf_library_is_one_line_that_names_the_other_formats(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "lib3mf", None)
    with pytest.raises(OutputError, match=r"write \.stl or \.glb"):
        export_design(design(), tmp_path / "block.3mf")
    assert list(tmp_path.iterdir()) == []
