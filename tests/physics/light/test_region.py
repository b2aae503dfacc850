"""A region of interest is the crop of the whole frame, to the last bit."""

import numpy as np
import pytest

from magicsim.simulation.stream import simulate

SMALL = (
    "design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "object.radius_mm=3", "references=2",
    "render.anchor_samples=4", "render.anchor_particles=8000", "render.particles=4000", "render.samples=2",
    "design.lattice.spacing_mm=1", "design.lattice.cells_across=0",
)  # fmt: skip
REGION = "rig.camera.region_px=[9, 20, 24, 30]"


def frames(small_scene, *overrides, state="near"):
    return simulate(small_scene(state, *SMALL, *overrides)).frames


@pytest.mark.parametrize("state", ["near", "pressed"])
def test_region_is_the_crop_of_the_whole_frame(small_scene, state):
    whole, part = frames(small_scene, state=state), frames(small_scene, REGION, state=state)
    for one, other in zip(whole, part, strict=True):
        np.testing.assert_array_equal(other.image, one.image[20:50, 9:33])
        np.testing.assert_array_equal(other.contact_mask, one.contact_mask[20:50, 9:33])


def test_region_far_from_the_border_is_the_crop_of_a_pressed_frame(small_scene):
    # More than what an anchored pixel looks at stays outside, on every side.
    large = ("rig.camera.columns=80", "rig.camera.rows=96", "rig.camera.field_mm=7")
    region = "rig.camera.region_px=[32, 40, 16, 16]"
    whole = frames(small_scene, *large, state="pressed")
    part = frames(small_scene, *large, region, state="pressed")
    np.testing.assert_array_equal(part[-1].image, whole[-1].image[40:56, 32:48])


@pytest.mark.parametrize("state", ["near", pytest.param("pressed", marks=pytest.mark.slow)])
def test_region_under_a_distorting_lens_is_the_crop_to_rounding(small_scene, state):
    lens = (
        "rig.camera.distortion=[-0.1,0.01,0.002,0.001,0]", "rig.camera.vignetting=0.3",
        "rig.camera.principal_offset_px=[2,-3]",
    )  # fmt: skip
    whole, part = frames(small_scene, *lens, state=state), frames(small_scene, *lens, REGION, state=state)
    difference = whole[-1].image[20:50, 9:33].astype(int) - part[-1].image
    assert np.abs(difference).max() <= 1
    assert (difference != 0).mean() < 0.01


def test_region_is_read_from_the_path_tracer_too(small_scene):
    path = ("render.estimator=path", "render.samples=2")
    np.testing.assert_array_equal(
        frames(small_scene, *path, REGION)[-1].image, frames(small_scene, *path)[-1].image[20:50, 9:33]
    )


def test_region_outside_the_image_is_refused(small_scene):
    with pytest.raises(ValueError, match="region_px"):
        small_scene("near", "rig.camera.region_px=[40, 0, 24, 30]")
