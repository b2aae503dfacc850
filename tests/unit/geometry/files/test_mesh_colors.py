import numpy as np
import pytest
import trimesh
from PIL import Image

from magicsim.errors import ConfigError
from magicsim.geometry.objects.kinds import parse_object


def box(**visual):
    return trimesh.Trimesh(*_arrays(), process=False, **visual)


def _arrays():
    plain = trimesh.creation.box((2, 2, 2))
    return plain.vertices, plain.faces


def colors_of(path, **settings):
    more = "".join(f",{key}={value}" for key, value in settings.items())
    return parse_object(f"mesh:path={path},file_colors=true{more}").surface()


def test_vertex_colors_are_interpolated_in_linear_light(tmp_path):
    vertices, _ = _arrays()
    shade = np.where(vertices[:, 2] > 0, 255, 0).astype(np.uint8)
    box(vertex_colors=np.column_stack([shade, shade, shade, np.full_like(shade, 255)])).export(tmp_path / "box.ply")
    surface = colors_of(tmp_path / "box.ply", scale=2)
    assert surface.colors.shape == surface.vertices.shape
    height = surface.vertices[:, 2] / 2  # of the file, whose box ends at 1
    np.testing.assert_allclose(surface.colors[height > 0.999], 1)
    np.testing.assert_allclose(surface.colors[height < -0.999], 0)
    middle = np.abs(height) < 1e-9
    assert middle.any()
    np.testing.assert_allclose(surface.colors[middle], 0.2140, atol=2e-3)  # sRGB 0.5


def test_face_colors_belong_to_their_faces(tmp_path):
    _, faces = _arrays()
    red = np.tile([255, 0, 0, 255], (len(faces), 1)).astype(np.uint8)
    box(face_colors=red).export(tmp_path / "box.ply")
    np.testing.assert_allclose(
        colors_of(tmp_path / "box.ply").colors, [[1, 0, 0]] * len(colors_of(tmp_path / "box.ply").vertices)
    )


def test_texture_is_looked_up_by_its_coordinates(tmp_path):
    vertices, _ = _arrays()
    picture = Image.fromarray(np.array([[[255, 0, 0], [0, 0, 255]]], np.uint8)).resize(
        (64, 64), Image.Resampling.NEAREST
    )
    uv = np.column_stack([(vertices[:, 0] + 1) / 2, np.full(len(vertices), 0.5)])
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=picture)
    box(visual=trimesh.visual.TextureVisuals(uv=uv, material=material)).export(tmp_path / "box.glb")
    surface = colors_of(tmp_path / "box.glb", scale=1)
    left, right = surface.vertices[:, 0] < -0.2, surface.vertices[:, 0] > 0.2
    np.testing.assert_allclose(surface.colors[left], [[1, 0, 0]] * left.sum())
    np.testing.assert_allclose(surface.colors[right], [[0, 0, 1]] * right.sum())


def test_file_without_colors_is_refused(tmp_path):
    box().export(tmp_path / "box.stl")
    with pytest.raises(ConfigError, match="has neither a texture nor colours"):
        colors_of(tmp_path / "box.stl")
