"""Domes and height maps: closed forms, the map of the block and its inverse, and what is refused."""

import os

import numpy as np
import pytest
from PIL import Image

from magicsim.config.models import load_preset
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import block_volume_mm3, build_elastomer
from magicsim.geometry.face_shape import Dome, HeightMap, flattened, lifted
from magicsim.geometry.files.export import printed_parts
from magicsim.geometry.indenter import first_touch_mm
from magicsim.geometry.objects import parse_object
from magicsim.geometry.pose import Pose

PLACES = np.random.default_rng(1).uniform(-6, 6, (200, 2))


def dome(**changes):
    return Dome(kind="dome", **{"radius_x_mm": 20.0, "radius_y_mm": 20.0, "crown_mm": 3.0, "rim_mm": 0.0} | changes)


def test_equal_radii_are_a_sphere_and_one_alone_a_cylinder():
    across = (PLACES**2).sum(1)
    np.testing.assert_allclose(dome().rise_mm(PLACES), 20 - np.sqrt(400 - across), atol=1e-12)
    np.testing.assert_allclose(
        dome(radius_y_mm=None).rise_mm(PLACES), 20 - np.sqrt(400 - PLACES[:, 0] ** 2), atol=1e-12
    )


def test_rim_is_smooth_and_ends_at_the_crown():
    x = np.linspace(0, 15, 3001)
    rise = dome(crown_mm=1.5, rim_mm=0.4).rise_mm(np.column_stack([x, 0 * x]))
    assert rise[0] == 0
    assert rise[-1] == pytest.approx(1.5)
    slope = np.diff(rise) / np.diff(x)
    assert np.abs(np.diff(slope)).max() < 0.01
    assert (slope >= -1e-12).all()


@pytest.mark.parametrize("face", [None, dome(crown_mm=2.0, rim_mm=0.3)])
def test_flattening_undoes_lifting(face):
    points = np.column_stack([PLACES, np.linspace(0, 6, len(PLACES))])
    np.testing.assert_allclose(flattened(lifted(points, face, 6.0), face, 6.0), points, atol=1e-12)


@pytest.mark.parametrize("side", [0.0, 3.0, 7.0])
def test_ball_touches_a_spherical_dome_where_their_centres_say(side):
    ball = parse_object("sphere:radius_mm=4").shape()
    pose = Pose.from_degrees(np.array([side, 0, -4.0]))
    travel = first_touch_mm(ball, pose, dome(crown_mm=9.0), (24.0, 32.0))
    assert travel == pytest.approx(20 - np.sqrt(24**2 - side**2) + 4, abs=2e-5)


@pytest.mark.parametrize("place", [(0.125, 0.125), (3.1, -5.14)])
@pytest.mark.parametrize(
    "text",
    [
        "cone:half_angle_deg=10,length_mm=8",
        "cone:half_angle_deg=20,length_mm=15",
        "punch:radius_mm=0.1,edge_radius_mm=0.02",
        "domed_cylinder:radius_mm=0.1,edge_radius_mm=0.05",
    ],
)
def test_slender_object_touches_between_the_places_that_are_looked_at(text, place):
    face, thing = dome(crown_mm=3.0), parse_object(text)
    near = np.linspace(-1, 1, 401)
    places = np.stack(np.meshgrid(near + place[0], near + place[1]), -1).reshape(-1, 2)
    level = Pose.from_degrees(np.array([*place, -thing.shape().support_mm(np.array([0, 0, 1.0]))]))
    travel = first_touch_mm(thing.shape(), level, face, (24.0, 32.0))
    points = np.column_stack([places, face.rise_mm(places) - travel])
    assert thing.shape().distance(level.to_object(points))[0].min() == pytest.approx(0, abs=1e-3)


def test_height_map_is_read_with_its_rows_from_above(tmp_path):
    x, y = np.meshgrid(np.linspace(-12, 12, 25), np.linspace(16, -16, 33))
    path = tmp_path / "face.npy"
    np.save(path, 5 - 0.01 * x**2 - 0.02 * (y - 2) ** 2)
    face = HeightMap(kind="height_map", file=str(path), footprint_mm=(24.0, 32.0))
    expected = 0.01 * PLACES[:, 0] ** 2 + 0.02 * (PLACES[:, 1] - 2) ** 2
    np.testing.assert_allclose(face.rise_mm(PLACES), expected, atol=2e-3)


def design(*overrides):
    return load_preset(ElastomerDesign, "design", "mini-magictac", ["footprint_mm=[8,9]", *overrides])


def test_curved_print_is_watertight_and_has_its_volume():
    curved = design('face={kind="dome",radius_x_mm=12,radius_y_mm=16,crown_mm=1.2}')
    parts = printed_parts(build_elastomer(curved))
    assert all(part.mesh.is_watertight() for part in parts)
    assert sum(part.mesh.volume_mm3() for part in parts) == pytest.approx(block_volume_mm3(curved), rel=5e-3)
    lowest = parts[0].mesh.vertices[:, 2].min()
    assert 0 <= lowest < 0.02


@pytest.mark.parametrize(
    ("face", "said"),
    [
        ('{kind="dome",radius_x_mm=8,crown_mm=5}', "crown_mm = 5 is not allowed"),
        ('{kind="dome",crown_mm=1}', "radius_x_mm and radius_y_mm are missing"),
        ('{kind="dome",radius_x_mm=2,crown_mm=3}', "must be at most the smaller radius"),
        ('{kind="dome",radius_x_mm=20,crown_mm=1,rim_mm=2}', "rim_mm = 2 is not allowed"),
        ('{kind="height_map",file="none.npy",footprint_mm=[8,9]}', r"face\.file = 'none\.npy' does not exist"),
    ],
)
def test_face_that_cannot_be_is_told_in_one_line(face, said):
    with pytest.raises(ConfigError, match=said) as caught:
        design(f"face={face}")
    assert "\n" not in str(caught.value)


def test_height_map_that_is_written_anew_is_read_anew(tmp_path):
    path = tmp_path / "hill.npy"
    face = HeightMap(kind="height_map", file=str(path), footprint_mm=(8, 9))
    for number, height in enumerate((0.1, 0.2), 1):
        np.save(path, height * np.outer(np.hanning(9), np.hanning(9)))
        os.utime(path, (number, number))
        assert face.rise_mm(np.array([[4.0, 4.5]]))[0] == pytest.approx(height)


def test_block_is_built_anew_for_a_height_map_with_other_content(tmp_path):
    path, volumes = tmp_path / "hill.npy", []
    for height in (0.1, 0.3):
        np.save(path, height * np.outer(np.hanning(9), np.hanning(9)))
        block = load_preset(
            ElastomerDesign, "design", "uniform-block",
            ["footprint_mm=[8,9]", f'face={{kind="height_map",file="{path}",footprint_mm=[8,9]}}'],
        )  # fmt: skip
        volumes.append(build_elastomer(block).body.volume_mm3())
    assert volumes[1] < 0.98 * volumes[0]


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "RGB", "RGBA", "I;16"])
def test_white_of_any_kind_of_png_is_as_high(tmp_path, mode):
    shades = np.repeat(np.array([0, 255], np.uint8), 10)[None].repeat(8, 0)
    picture = Image.fromarray(shades.astype(np.uint16) * 257) if mode == "I;16" else Image.fromarray(shades)
    picture = picture if mode == "I;16" else picture.convert(mode)
    assert picture.mode == mode
    picture.save(tmp_path / "step.png")
    face = HeightMap(kind="height_map", file=str(tmp_path / "step.png"), footprint_mm=(20, 8), range_mm=0.5)
    assert face.rise_mm(np.array([[-10.0, 0.0]]))[0] == pytest.approx(0.5, rel=1e-3)
    assert face.rise_mm(np.array([[10.0, 0.0]]))[0] == pytest.approx(0, abs=1e-3)


def test_file_that_holds_no_heights_is_told_in_one_line(tmp_path):
    (tmp_path / "empty.npy").write_bytes(b"")
    Image.new("1", (20_000, 10_000)).save(tmp_path / "huge.png")
    for name in ("empty.npy", "huge.png"):
        with pytest.raises(ConfigError, match=r"must be a PNG or an NPY of two dimensions"):
            design(f'face={{kind="height_map",file="{tmp_path / name}",footprint_mm=[8,9]}}')
