import numpy as np
import pytest

from magicsim.camera.projection import picture_mm, pixel_landing_mm, project_px
from magicsim.scenes.scene import SceneConfig, load_scene


def scene(*settings: str) -> SceneConfig:
    return load_scene("rest", ["rig.camera.columns=24", "rig.camera.rows=32", *settings])


@pytest.mark.parametrize("z_mm", [0.0, 1.3, 6.6])
@pytest.mark.parametrize(
    "settings",
    [
        [],
        ["rig.lens.thickness_mm=0"],
        ["rig.camera.distortion=[-0.1,0.02,0.001,0.002,0]", "rig.camera.principal_offset_px=[1.5,-0.7]"],
        ["rig.camera.region_px=[4,6,10,12]"],
    ],
)
def test_where_a_pixel_looks_is_seen_in_that_pixel(settings: list[str], z_mm: float):
    case = scene(*settings)
    landing = pixel_landing_mm(case.design, case.rig.lens, case.rig.camera, z_mm=z_mm)
    found = project_px(
        np.dstack([landing, np.full(landing.shape[:2], z_mm)]), case.design, case.rig.lens, case.rig.camera
    )
    row, column = np.mgrid[: landing.shape[0], : landing.shape[1]]
    np.testing.assert_allclose(found, np.dstack([column, row]), atol=2e-4)  # px; the inverse of the lens is that good


def test_points_nearer_to_the_camera_are_seen_farther_out():
    case = scene()
    low, high = project_px(np.array([[5.0, 5.0, 0.0], [5.0, 5.0, 6.0]]), case.design, case.rig.lens, case.rig.camera)
    middle = project_px(np.zeros((1, 3)), case.design, case.rig.lens, case.rig.camera)[0]
    assert (np.abs(high - middle) > np.abs(low - middle) + 0.5).all()
    assert high[0] > middle[0]  # +x is right
    assert high[1] < middle[1]  # +y is up


@pytest.mark.parametrize("settings", [[], ["rig.camera.columns=32", "rig.camera.rows=24"]])
def test_picture_covers_the_rectangle_of_the_face_whose_corners_it_sees(settings: list[str]):
    case = scene(*settings)
    low, high = picture_mm(case.design, case.rig.lens, case.rig.camera)
    camera = case.rig.camera
    size = np.array([camera.field_mm, camera.field_mm * camera.rows / camera.columns])
    np.testing.assert_allclose(high - low, size, atol=2 * camera.field_mm / camera.columns)
    for share, is_seen in ((0.99, True), (1.1, False)):
        corners = np.array([[x * share, y * share, 0.0] for x in (low[0], high[0]) for y in (low[1], high[1])])
        pixels = project_px(corners, case.design, case.rig.lens, case.rig.camera)
        inside = (pixels > -0.5) & (pixels < [case.rig.camera.columns - 0.5, case.rig.camera.rows - 0.5])
        assert inside.all() == is_seen
