"""Copies start where vectors may be read, whatever they are copies of."""

import numpy as np
import pytest

from magicsim.light.backend import BYTES, aligned, columns


@pytest.mark.parametrize("size", [0, 1, 7, 1000])
@pytest.mark.parametrize("kind", [np.float32, np.uint32])
def test_a_copy_is_the_same_and_starts_where_vectors_may(size, kind):
    source = np.arange(3 * (size + 1))[1 : 1 + 2 * size].reshape(size, 2)
    copy = aligned(source, kind)
    assert copy.dtype == kind
    assert copy.ctypes.data % BYTES == 0 or size == 0
    np.testing.assert_array_equal(copy, source)


def test_every_column_starts_there():
    source = np.arange(21.0).reshape(7, 3)
    found = columns(source)
    assert [column.ctypes.data % BYTES for column in found] == [0, 0, 0]
    np.testing.assert_array_equal(np.stack(found, 1), source)
