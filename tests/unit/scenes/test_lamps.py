"""Single LEDs and rings: what is refused, and their surfaces."""

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.light.world.lamp_shapes import disks
from magicsim.scenes.scene import load_scene


@pytest.mark.parametrize(
    ("override", "said"),
    [
        (
            "rig.leds=[{place_mm=[0,0,3],direction=[0,0,1],radiance=[1,1,1]}]",
            r"rig.leds.0.place_mm = \[0.0, 0.0, 3.0\] is not allowed: must be outside of the block",
        ),
        ("rig.leds=[{place_mm=[0,0,30],direction=[0,0,0],radiance=[1,1,1]}]", "direction = .* must not be 0"),
        ("rig.ring={radiance=[1,1,1],radius_mm=10,gap_mm=30}", "ring.gap_mm = 30 is not allowed"),
        ("rig.ring={radiance=[1,1,1],radius_mm=1,width_mm=3}", "width_mm = 3 is not allowed"),
    ],
)
def test_light_that_cannot_be_is_told_in_one_line(override, said):
    with pytest.raises(ConfigError, match=said) as caught:
        load_scene("rest", [override])
    assert "\n" not in str(caught.value)


def test_disks_have_the_area_of_circles_and_face_along_their_axis():
    axis = np.array([0.6, 0.0, -0.8])
    mesh = disks(np.array([[1.0, 2, 3], [4, 5, 6]]), axis, 0.7)
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    np.testing.assert_allclose(normal.sum(0), 2 * np.pi * 0.49 * axis, atol=1e-9)
