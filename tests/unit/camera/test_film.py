"""The lens: places and shading of pixels, and the calibration that describes them."""

import cv2
import numpy as np
import pytest

from magicsim.camera.camera import Camera, Lens
from magicsim.camera.film import film
from magicsim.camera.projection import calibrate_camera, camera_matrix, focal_px, pixel_landing_mm, pixel_slopes
from magicsim.config.models import load_preset
from magicsim.errors import RenderError
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig

DESIGN = load_preset(ElastomerDesign, "design", "mini-magictac", [])
BARREL = (-0.15, 0.02, 0.001, -0.002, 0.0)


LENS = Lens()


def camera(**settings) -> Camera:
    return Camera(columns=60, rows=80, **settings)


def rig(**settings) -> Rig:
    return Rig(schema_version=1, strips=(), camera=camera(**settings))


def test_an_ideal_lens_looks_nothing_up() -> None:
    found = film(DESIGN, LENS, camera(blur_px=0))
    assert (found.columns, found.rows, found.places_px, found.shading) == (60, 80, None, None)
    image = np.random.default_rng(0).random((80, 60, 3), np.float32)
    np.testing.assert_array_equal(found.seen(image), image)


def test_distorted_pixels_see_what_opencv_projects_onto_them() -> None:
    """Rays of all pixels, projected with the exported calibration, meet the pixels' centres."""
    sensor = rig(distortion=BARREL, principal_offset_px=(2.0, -3.0))
    slopes = pixel_slopes(sensor.camera, focal_px(DESIGN, sensor.lens, sensor.camera)).reshape(-1, 2)
    rays = np.concatenate([slopes, np.ones((len(slopes), 1))], 1)
    calibration = calibrate_camera(DESIGN, sensor)
    seen = cv2.projectPoints(
        rays, np.zeros(3), np.zeros(3), np.array(calibration.camera_matrix), np.array(calibration.distortion)
    )[0]
    column, row = np.meshgrid(np.arange(60), np.arange(80))
    np.testing.assert_allclose(seen[:, 0], np.stack([column.ravel(), row.ravel()], 1), atol=1e-3)


def test_the_ideal_image_covers_every_pixel_and_keeps_its_focal_length() -> None:
    sensor = rig(distortion=BARREL, principal_offset_px=(4.0, 0.0))
    found, focal = film(DESIGN, sensor.lens, sensor.camera), focal_px(DESIGN, sensor.lens, sensor.camera)
    assert found.places_px is not None
    assert found.places_px.min() >= 0
    assert (found.places_px.max((0, 1)) <= [found.columns - 1, found.rows - 1]).all()
    assert found.columns / 2 / np.tan(np.radians(found.fov_deg / 2)) == pytest.approx(focal)


def test_a_picture_of_directions_is_seen_where_the_pixels_look() -> None:
    """An ideal image that holds its own slopes comes out as each pixel's slopes."""
    sensor = rig(distortion=BARREL, principal_offset_px=(4.0, 1.0), blur_px=0)
    found, focal = film(DESIGN, sensor.lens, sensor.camera), focal_px(DESIGN, sensor.lens, sensor.camera)
    column, row = np.meshgrid(np.arange(found.columns), np.arange(found.rows))
    x, y = (column - (found.columns - 1) / 2) / focal, (row - (found.rows - 1) / 2) / focal
    ideal = np.stack([x, y, np.ones_like(x)], -1).astype(np.float32)
    np.testing.assert_allclose(found.seen(ideal)[..., :2], pixel_slopes(sensor.camera, focal), atol=2e-4)


def test_an_offset_moves_what_is_seen() -> None:
    plain, moved = (
        pixel_landing_mm(DESIGN, LENS, camera(principal_offset_px=offset)) for offset in ((0.0, 0.0), (3.0, 2.0))
    )
    np.testing.assert_allclose(moved[2:, 3:], plain[:-2, :-3], atol=1e-9)


def test_corners_lose_the_share_that_is_asked_for() -> None:
    seen = film(DESIGN, LENS, camera(vignetting=0.4)).seen(np.ones((80, 60, 3), np.float32))
    assert seen[40, 30].min() > 0.999
    np.testing.assert_allclose(seen[0, 0], 0.6, atol=0.02)


@pytest.mark.parametrize("blur_px", [0.7, 2.0])
def test_a_point_spreads_as_wide_as_asked_and_keeps_its_light(blur_px) -> None:
    point = np.zeros((80, 60, 3), np.float32)
    point[40, 30] = 5.0
    seen = film(DESIGN, LENS, camera(blur_px=blur_px)).seen(point)[..., 0].astype(float)
    assert seen.sum() == pytest.approx(5, rel=1e-5)
    rows, columns = np.indices(seen.shape)
    spread = [np.sqrt((seen * (axis - at) ** 2).sum() / seen.sum()) for axis, at in ((rows, 40), (columns, 30))]
    assert spread == pytest.approx([blur_px, blur_px], rel=0.03)


def test_a_region_is_as_blurred_as_the_whole_image() -> None:
    image = np.random.default_rng(1).random((80, 60, 3), np.float32)
    whole, part = (
        film(DESIGN, LENS, camera(vignetting=0.3, **region)) for region in ({}, {"region_px": (10, 20, 30, 40)})
    )
    seen = part.seen(np.asarray(part.window.of(image)))
    np.testing.assert_array_equal(seen, whole.seen(image)[20:60, 10:40])


def test_a_distortion_that_folds_the_image_is_refused() -> None:
    with pytest.raises(RenderError, match=r"camera\.distortion"):
        film(DESIGN, LENS, camera(distortion=(-1.0, -1.0, 0.0, 0.0, -1.0), distance_mm=5.0))


def test_scale_of_each_layer_is_that_of_its_rays() -> None:
    """Paraxial rays: (distance + depth / n) / focal length; nearer layers look larger."""
    sensor = rig()
    found = calibrate_camera(DESIGN, sensor)
    focal = camera_matrix(sensor.camera, focal_px(DESIGN, sensor.lens, sensor.camera))[0, 0]
    for layer in found.layers:
        depth = (DESIGN.height_mm + sensor.lens.thickness_mm - layer.z_mm) / found.ior
        assert layer.mm_per_pixel[0] == pytest.approx((sensor.camera.distance_mm + depth) / focal, rel=1e-3)
    scales = [layer.mm_per_pixel[0] for layer in found.layers]
    assert scales == sorted(scales, reverse=True)
    assert [found.layers[0].name, found.layers[-1].name] == ["contact face", "bonded face"]


@pytest.mark.parametrize("rendered_px", [2.0, 3.0])
def test_larger_pixels_show_everything_at_its_place(rendered_px: float) -> None:
    """An image that rises evenly with a ray's slope rises evenly with the camera's pixels, whatever is rendered."""
    sensor = rig(blur_px=0, rendered_px=rendered_px)
    found, focal = film(DESIGN, sensor.lens, sensor.camera), focal_px(DESIGN, sensor.lens, sensor.camera)
    assert found.columns * found.rows < 60 * 80 / (rendered_px - 0.5)
    ideal = found.columns / 2 / np.tan(np.radians(found.fov_deg / 2))
    assert ideal == pytest.approx(focal / rendered_px)
    window = found.window
    column = np.arange(window.column, window.column + window.columns) - (found.columns - 1) / 2
    row = np.arange(window.row, window.row + window.rows) - (found.rows - 1) / 2
    slopes = np.stack(np.broadcast_arrays(column / ideal, row[:, None] / ideal, 1.0), -1).astype(np.float32)
    seen = found.seen(slopes)
    np.testing.assert_allclose(seen[..., :2], pixel_slopes(sensor.camera, focal), atol=2e-3 / focal * rendered_px)
