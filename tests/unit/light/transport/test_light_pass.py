import numpy as np
import pytest

from magicsim.errors import RenderError
from magicsim.light.variant import SCALAR_VARIANT, activate_variant

pytestmark = pytest.mark.skipif(activate_variant() == SCALAR_VARIANT, reason="needs LLVM or CUDA")


def tracks(value: int):
    from magicsim.light.transport.light_pass import Tracks

    one = np.full(3, value, np.uint64)
    return Tracks(cells=one, body=one, landed=one, balance=None)


def test_tracks_of_chunks_add_up():
    from magicsim.light.transport.light_pass import sum_tracks

    assert sum_tracks([tracks(2**61), tracks(3)]).cells.tolist() == [2**61 + 3] * 3


def test_sums_beyond_the_digits_of_the_integers_are_refused():
    from magicsim.light.transport.light_pass import sum_tracks

    with pytest.raises(RenderError, match=r"lower render\.particles"):
        sum_tracks([tracks(2**62)] * 4)
