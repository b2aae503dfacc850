"""What the pictures must show: orientation, darkness, colour, contact."""

import numpy as np
import pytest

from magicsim.scenes.timeline import UNTOUCHED, View, timeline
from magicsim.simulation.sensor import Sensor


@pytest.fixture(scope="module")
def rest(whole_block):
    return np.array(Sensor.for_scene(whole_block("rest")).renderer.plain_radiance(View()))


def test_red_is_at_column_zero_and_blue_at_the_last(rest):
    red, blue = rest[..., 0].mean(0), rest[..., 2].mean(0)
    assert red[:8].mean() > 3 * red[-8:].mean()
    assert blue[-8:].mean() > 3 * blue[:8].mean()


def test_green_lights_both_ends_of_the_rows(rest):
    green = rest[..., 1].mean(1)
    middle = green[28:36].mean()
    assert green[:6].mean() > 1.5 * middle
    assert green[-6:].mean() > 1.5 * middle


def test_object_at_plus_x_and_plus_y_appears_right_of_and_above_the_centre(whole_block):
    scene = whole_block("near", "object.radius_mm=3", "object.color=[0.9, 0.9, 0.9]")
    sensor = Sensor.for_scene(scene)
    state = timeline(scene)[0]
    moved = type(state)(gap_mm=0.2, x_mm=5.0, y_mm=8.0, twist_deg=0.0, flashlight=False, light_x_mm=0.0)
    brighter = np.clip(
        sensor.renderer.plain_radiance(sensor.view(moved, sensor.rest))
        - sensor.renderer.plain_radiance(sensor.view(UNTOUCHED, sensor.rest)),
        0,
        None,
    ).sum(-1)
    rows, columns = np.indices(brighter.shape)
    assert (brighter * columns).sum() / brighter.sum() > 24 + 4
    assert (brighter * rows).sum() / brighter.sum() < 32 - 4


def test_sensor_without_light_is_black(small_scene):
    dark = small_scene("near", "rig.strips=[]")
    sensor = Sensor.for_scene(dark)
    image = sensor.renderer.plain_radiance(sensor.view(timeline(dark)[0], sensor.rest))
    assert image.max() == 0


def test_image_is_linear_in_the_lights(small_scene):
    plain = small_scene("near")
    bright = plain.model_copy(
        update={
            "rig": plain.rig.model_copy(
                update={
                    "strips": tuple(
                        strip.model_copy(update={"radiance": tuple(2 * part for part in strip.radiance)})
                        for strip in plain.rig.strips
                    )
                }
            )
        }
    )
    one, two = (
        sensor.renderer.plain_radiance(sensor.view(timeline(plain)[0], sensor.rest))
        for sensor in (Sensor.for_scene(plain), Sensor.for_scene(bright))
    )
    np.testing.assert_allclose(two, 2 * one, rtol=1e-3, atol=1e-6)


def test_image_of_a_mirrored_object_is_the_mirrored_image_in_green(small_scene):
    # The block and the green strips are symmetric about x = 0, so green may differ by noise only.
    scene = small_scene("near", "render.particles=150000", "render.samples=32")
    sensor = Sensor.for_scene(scene)
    state = timeline(scene)[0]

    def green(x_mm):
        moved = type(state)(gap_mm=0.5, x_mm=x_mm, y_mm=0.0, twist_deg=0.0, flashlight=False, light_x_mm=0.0)
        return sensor.renderer.plain_radiance(sensor.view(moved, sensor.rest))[..., 1]

    left, right = green(-2.0), green(2.0)[:, ::-1]
    blocks = [each.reshape(4, 16, 6, 8).mean((1, 3)) for each in (left, right)]
    np.testing.assert_allclose(blocks[0], blocks[1], rtol=0.06)
    assert abs(left.mean() / right.mean() - 1) < 0.01


def test_block_without_scattering_shows_no_light_of_its_own(rest, whole_block):
    clear = whole_block("rest", "design.materials.infill.sigma_s_per_mm=0")
    image = Sensor.for_scene(clear).renderer.plain_radiance(View())
    assert np.median(image) < 0.05 * np.median(rest)
