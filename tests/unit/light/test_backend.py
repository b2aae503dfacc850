import pytest

from magicsim.errors import RenderError
from magicsim.light.backend import VARIANT, mi


def test_variant_that_somebody_else_sets_is_one_line():
    import mitsuba  # after magicsim, as it must be

    try:
        mitsuba.set_variant("scalar_rgb" if VARIANT != "scalar_rgb" else "scalar_spectral")
        with pytest.raises(RenderError, match=rf"was called: set_variant\('{VARIANT}'\) before magicsim renders again"):
            mi.Float(1.0)
    finally:
        mitsuba.set_variant(VARIANT)
    assert mi.Float is mitsuba.Float
