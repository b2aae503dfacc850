"""Coats of the contact face: what is refused, and what of them is felt."""

import pytest

from magicsim.config.models import validate
from magicsim.errors import ConfigError
from magicsim.geometry.coat import HalfMirror, OpaqueCoat


def test_film_that_makes_light_is_refused():
    with pytest.raises(ConfigError, match=r"reflectance \+ transmittance = 1.1 is not allowed"):
        validate(HalfMirror, {"kind": "half_mirror", "reflectance": 0.6, "transmittance": 0.5}, source="coat")


def test_coat_is_felt_only_with_thickness_and_modulus():
    assert OpaqueCoat(kind="opaque").shear_n_per_mm == 0
    coat = OpaqueCoat(kind="opaque", thickness_mm=0.03, modulus_mpa=2.0)
    assert coat.shear_n_per_mm == pytest.approx(0.03 * 2 / 3)
    assert coat.problem(3.0, 0.15) is None
    with pytest.raises(ConfigError, match="thickness_mm is missing: a coat with modulus_mpa needs both"):
        validate(OpaqueCoat, {"kind": "opaque", "modulus_mpa": 2.0}, source="coat")


def test_coat_folds_over_its_thickness_times_the_cube_root_of_the_contrast():
    coat = OpaqueCoat(kind="opaque", thickness_mm=0.05, modulus_mpa=24.0)
    assert coat.wrinkle_mm(1.0) == pytest.approx(0.1)
    assert coat.problem(3.0, 1.0) is None
    assert "must be at most 0.25 mm" in (coat.problem(3.0, 0.05) or "")
