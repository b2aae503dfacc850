"""A room has a mean, a side where its window is, and one line for images that are none."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from magicsim.errors import ConfigError
from magicsim.light.backend import VARIANT, mi
from magicsim.scenes.room import room_names, room_radiance, solid_angles
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import View
from magicsim.simulation.sensor import Sensor

LIT = "rig.ambient=[0.2,0.2,0.2]"
SMALL = (
    "design.footprint_mm=[6,7]", "design.lattice.cells_across=0", "rig.camera.columns=8", "rig.camera.rows=8",
    "rig.camera.field_mm=5",
)  # fmt: skip


@pytest.mark.parametrize("name", room_names())
def test_mean_over_all_directions_is_one_whatever_the_exposure(name):
    radiance = room_radiance(name)
    mean = (radiance * solid_angles(len(radiance))[:, None, None]).sum(0).mean(0)
    np.testing.assert_allclose(mean, 1, rtol=1e-12)
    assert radiance.std() > 0.3  # a room has structure


def test_rows_share_the_sphere():
    rows = solid_angles(500)
    assert rows.sum() == pytest.approx(1)
    # Archimedes: the zone between two heights has the same share as their distance.
    assert rows[:125].sum() == pytest.approx((1 - np.cos(np.pi / 4)) / 2)


@pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
def test_the_middle_is_ahead_the_upper_edge_above_and_the_right_half_on_the_right(tmp_path):
    picture = np.full((64, 128, 3), 20, np.uint8)
    picture[24:40, 56:72] = (255, 20, 20)  # ahead
    picture[:10] = (20, 255, 20)  # above
    picture[24:40, 88:104] = (20, 20, 255)  # right
    Image.fromarray(picture).save(tmp_path / "room.png")
    sensor = Sensor.for_scene(load_scene("rest", [*SMALL, LIT, f"rig.room='{tmp_path / 'room.png'}'"]))
    environment = sensor.renderer.world(View()).scene.environment()

    def seen(*direction):
        si = mi.SurfaceInteraction3f()
        si.wi = -mi.Vector3f(*direction)
        return int(np.argmax(np.array(environment.eval(si)).ravel()))

    assert [seen(0, 0, -1), seen(0, 1, 0), seen(1, 0, 0)] == [0, 1, 2]


@pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
def test_a_touch_in_a_room_is_the_same_whatever_was_seen_before():
    quick = ("render.anchor_samples=4", "render.anchor_particles=10000", "render.particles=2000", "render.samples=2")
    press = "keyframes=[{frame=0,gap_mm=-0.3}]"
    images = []
    for gaps_mm in ((), (300.0, 2.0)):
        sensor = Sensor.for_scene(
            load_scene("pressed", [*SMALL, *quick, LIT, "rig.room='window'", press, "object.radius_mm=2"])
        )
        touch = sensor.states[0]
        for gap_mm in gaps_mm:
            sensor.renderer.plain_radiance(sensor.view(replace(touch, gap_mm=gap_mm), sensor.rest))
            sensor.radiance(replace(touch, gap_mm=gap_mm), sensor.rest)
        images.append(sensor.radiance(touch, sensor.deform(touch, sensor.rest)))
    np.testing.assert_array_equal(*images)


def test_the_dark_room_shines_on_nothing():
    rig = load_scene("rest", [LIT, "rig.room='dark'"]).rig
    assert rig.room_light == (0, 0, 0)
    assert load_scene("rest", [LIT, "rig.room='office'"]).rig.room_light == (0.2, 0.2, 0.2)


@pytest.mark.parametrize(
    ("size", "value", "message"),
    [((64, 64), 90, "has 64 x 64 pixels: must be twice as wide"), ((64, 32), 0, "is black in a channel")],
)
def test_images_that_are_no_room_are_refused(tmp_path, size, value, message):
    Image.new("RGB", size, (value, value, value)).save(tmp_path / "room.png")
    with pytest.raises(ConfigError, match=message):
        load_scene("rest", [LIT, f"rig.room='{tmp_path / 'room.png'}'"])


@pytest.mark.parametrize("mode", ["I;16", "F", "CMYK"])
def test_pixels_of_another_kind_are_one_line(tmp_path, mode):
    name = "room.png" if mode == "I;16" else "room.jpg" if mode == "CMYK" else "room.tiff"
    Image.new(mode, (64, 32)).save(tmp_path / name)
    path = (tmp_path / name).rename((tmp_path / name).with_suffix(".jpg" if mode == "CMYK" else ".png"))
    with pytest.raises(ConfigError, match=f"pixels of kind {mode}: must be 8-bit") as told:
        load_scene("rest", [LIT, f"rig.room='{path}'"])
    assert "\n" not in str(told.value)


def test_a_file_that_is_no_image_is_one_line(tmp_path):
    (tmp_path / "room.png").write_text("nothing")
    with pytest.raises(ConfigError, match="is no image that can be read"):
        load_scene("rest", [LIT, f"rig.room='{tmp_path / 'room.png'}'"])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ((LIT, "rig.room='kitchen'"), "kitchen.*office"),
        ((LIT, "rig.room='nowhere.png'"), "does not exist"),
        (("rig=digit-rgb", "rig.room='office'"), "not allowed with ambient = 0"),
    ],
)
def test_rooms_that_cannot_be_are_one_line(settings, message):
    with pytest.raises(ConfigError, match=message) as told:
        load_scene("rest", list(settings))
    assert "\n" not in str(told.value)
