"""The picture of a coated and marked face."""

import numpy as np
import pytest
from PIL import Image

from magicsim.config.models import load_preset
from magicsim.geometry import face_paint as face_paint_module
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.face_paint import face_paint

DOTS = 'markers={kind="dots",pitch_mm=3.0,diameter_mm=1.2,color=[0.1,0.1,0.1]}'
COAT = 'coat={kind="opaque",color=[0.5,0.4,0.3]}'


def paint(*overrides):
    return face_paint(load_preset(ElastomerDesign, "design", "uniform-block", overrides))


def test_bare_and_filmed_faces_have_none():
    assert paint() is None
    assert paint('coat={kind="half_mirror",reflectance=0.3,transmittance=0.4}') is None


def test_dots_cover_their_area():
    found = paint(DOTS)
    area = found.texels[..., 3].sum() * found.pixel_mm**2
    dots = 7 * 9
    assert area == pytest.approx(dots * np.pi * 0.6**2, rel=5e-3)


def test_coat_is_opaque_everywhere_and_dots_change_its_colour():
    found = paint(DOTS, COAT)
    assert (found.texels[..., 3] == 1).all()
    colors = found.texels[..., :3].reshape(-1, 3)
    assert colors.min() == pytest.approx(0.1)
    np.testing.assert_allclose(np.median(colors, 0), [0.5, 0.4, 0.3])


def test_picture_finer_than_a_texel_is_averaged(tmp_path):
    shares = np.zeros((400, 800, 4), np.uint8)
    shares[:, :, 0], shares[:, 400:, 3] = 255, 255
    shares[100:300, :400, 3], shares[100:300, :400, 0] = 255, 0
    Image.fromarray(shares).save(tmp_path / "fine.png")
    found = paint(f'markers={{kind="picture",file="{tmp_path / "fine.png"}",width_mm=0.8}}')
    assert found.pixel_mm == pytest.approx(0.01, rel=0.5)
    assert found.texels.size < 20 * face_paint_module.MOST_PIXELS
    opacity = found.texels[..., 3]
    assert opacity.sum() * found.pixel_mm**2 == pytest.approx(0.4 * 0.4 + 0.2 * 0.4, rel=0.02)
    rows, columns = np.nonzero(opacity > 0.99)
    places = np.stack([columns, rows], -1) * found.pixel_mm + found.origin_mm
    red = found.texels[rows, columns, 0] > 0.99
    assert places[red].min(0) == pytest.approx([0, -0.2], abs=0.03)
    assert places[~red].min(0) == pytest.approx([-0.4, -0.1], abs=0.03)
