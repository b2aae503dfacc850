import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.geometry.objects.kinds import parse_object


def test_plug_is_a_handle_with_a_pin():
    plug = parse_object("plug:radius_mm=5,length_mm=12,pin_radius_mm=2.5,pin_length_mm=10")
    solid, mesh = plug.shape(), plug.surface()
    assert solid.support_mm(np.array([0.0, 1.0, 0.0])) == pytest.approx(16)
    assert solid.support_mm(np.array([0.0, -1.0, 0.0])) == pytest.approx(6)
    assert solid.support_mm(np.array([0.0, 0.0, 1.0])) == pytest.approx(5)
    assert mesh.is_watertight()
    assert mesh.volume_mm3() == pytest.approx(np.pi * (25 * 12 + 6.25 * 10), rel=0.02)
    distance, normal = plug.solid().distance(mesh.vertices)
    assert np.abs(distance).max() < 0.01
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1)


def test_pin_as_thick_as_the_handle_is_refused():
    with pytest.raises(ConfigError, match="pin_radius_mm = 4 is not allowed: must be below the handle's end, 4"):
        parse_object("plug:radius_mm=5,pin_radius_mm=4")
