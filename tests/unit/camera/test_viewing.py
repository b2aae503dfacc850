import math

import numpy as np
import pytest

from magicsim.camera.camera import Camera, Lens
from magicsim.camera.projection import horizontal_fov_deg, pixel_landing_mm
from magicsim.config.models import load_preset
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig


def design(**settings: object) -> ElastomerDesign:
    return load_preset(
        ElastomerDesign, "design", "uniform-block", [f"{key}={value}" for key, value in settings.items()]
    )


def rig(**camera: object) -> Rig:
    small = {"columns": 24, "rows": 32} | camera
    return load_preset(Rig, "rig", "digit-rgb", [f"camera.{key}={value}" for key, value in small.items()])


def optics(**camera: object) -> tuple[Lens, Camera]:
    base = rig(**camera)
    return base.lens, base.camera


def landing_by_snell(
    angle_x: float, angle_y: float, *, distance_mm: float, depth_mm: float, ior: float
) -> tuple[float, float]:
    """One ray by the vector form of Snell's law, from slopes along x and y."""
    direction = np.array([angle_x, angle_y, -1.0]) / math.sqrt(angle_x**2 + angle_y**2 + 1)
    hit = direction * (distance_mm / -direction[2])
    normal = np.array([0.0, 0.0, 1.0])
    cosine = -float(direction @ normal)
    bent = direction / ior + (cosine / ior - math.sqrt(1 - (1 - cosine**2) / ior**2)) * normal
    end = hit + bent * (depth_mm / -bent[2])
    return float(end[0]), float(end[1])


def test_first_row_looks_at_plus_y_and_first_column_at_minus_x():
    landing = pixel_landing_mm(design(), *optics())
    assert landing.shape == (32, 24, 2)
    assert (np.diff(landing[..., 0], axis=1) > 0).all()
    assert (np.diff(landing[..., 1], axis=0) < 0).all()
    assert landing[0, 0, 0] < 0 < landing[0, 0, 1]


def test_view_is_symmetric_about_the_axis():
    landing = pixel_landing_mm(design(), *optics())
    assert landing[:, ::-1, 0] == pytest.approx(-landing[..., 0])
    assert landing[::-1, :, 1] == pytest.approx(-landing[..., 1])


@pytest.mark.parametrize("field_mm", [6.0, 22.8, 40.0])
@pytest.mark.parametrize("ior", [1.0, 1.49, 2.5])
def test_edge_of_the_image_lands_at_half_the_field(field_mm: float, ior: float):
    block, base = design(**{"materials.body.ior": ior}), rig(field_mm=field_mm)
    slope = math.tan(math.radians(horizontal_fov_deg(block, base.lens, base.camera) / 2))
    depth = block.height_mm + base.lens.thickness_mm
    x, y = landing_by_snell(slope, 0.0, distance_mm=base.camera.distance_mm, depth_mm=depth, ior=ior)
    assert x == pytest.approx(field_mm / 2, abs=1e-9)
    assert y == 0


def test_every_pixel_lands_where_snells_law_sends_its_ray():
    block, base = design(), rig(columns=10, rows=14)
    landing = pixel_landing_mm(block, base.lens, base.camera)
    half = math.tan(math.radians(horizontal_fov_deg(block, base.lens, base.camera) / 2))
    depth = block.height_mm + base.lens.thickness_mm
    for row in range(14):
        for column in range(10):
            slope_x = half * ((column + 0.5) / 5 - 1)
            slope_y = half * 14 / 10 * (1 - (row + 0.5) / 7)
            expected = landing_by_snell(slope_x, slope_y, distance_mm=24.0, depth_mm=depth, ior=1.49)
            assert landing[row, column] == pytest.approx(expected, abs=1e-9)


def test_pixels_are_square_without_refraction():
    landing = pixel_landing_mm(design(**{"materials.body.ior": 1.0}), *optics(field_mm=12.0))
    assert np.diff(landing[0, :, 0]) == pytest.approx([0.5] * 23)
    assert np.diff(landing[:, 0, 1]) == pytest.approx([-0.5] * 31)


def test_refraction_asks_for_a_wider_view_of_the_same_field():
    wide = horizontal_fov_deg(design(**{"materials.body.ior": 1.49}), *optics())
    straight = horizontal_fov_deg(design(**{"materials.body.ior": 1.0}), *optics())
    assert wide > straight
    assert straight == pytest.approx(2 * math.degrees(math.atan(11.4 / (24.0 + 6.0 + 2.0))))
