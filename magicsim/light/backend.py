"""Mitsuba and Dr.Jit with the variant set: import them from here, and the order of imports cannot go wrong.

They are untyped here: their stubs describe all variants at once. Dr.Jit looks for libLLVM when it is first imported,
so the right one must be named before that.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.errors import RenderError
from magicsim.light.variant import activate_variant

VARIANT = activate_variant()

import drjit  # noqa: E402
import mitsuba  # noqa: E402


class _Mitsuba:
    """Mitsuba, as long as its variant is the one that everything here was made with."""

    def __getattr__(self, name: str) -> Any:
        if (now := mitsuba.variant()) != VARIANT:
            msg = f"mitsuba.set_variant('{now}') was called: set_variant('{VARIANT}') before magicsim renders again"
            raise RenderError(msg)
        return getattr(mitsuba, name)


dr: Any = drjit
mi: Any = _Mitsuba()


@contextmanager
def plain_errors() -> Iterator[None]:
    """Errors as they were raised, Ctrl-C among them: the renderer's loops wrap each into a `RuntimeError`."""
    try:
        yield
    except RuntimeError as error:
        cause: BaseException = error
        while type(cause) is RuntimeError and cause.__cause__ is not None:
            cause = cause.__cause__
        raise cause from None


BYTES = 64
"""Length of the longest vector registers [bytes]."""


def aligned(values: npt.ArrayLike, kind: npt.DTypeLike) -> npt.NDArray[Any]:
    """A contiguous copy of the same shape, its elements of a kind, whose memory starts where vectors may be read.

    The renderer takes an array over where it lies, and compiles a kernel anew for each alignment that it meets, which
    takes longer than most frames.
    """
    source = np.asarray(values)
    room = np.empty(source.size * np.dtype(kind).itemsize + BYTES, np.uint8)
    start = -room.ctypes.data % BYTES
    copy = room[start : start + source.size * np.dtype(kind).itemsize].view(kind).reshape(source.shape)
    copy[...] = source
    return copy


def box_number(point: Any, origin: Sequence[float], size: Sequence[float], counts: Sequence[int]) -> Any:
    """Number of the box of a regular grid that holds each point, x fastest, mi.UInt32; points outside have the nearest.

    The low corner of the grid and a box's edges are in the points' unit; opaque: the compiled kernel serves any grid.
    """
    first, per_unit, last = (
        [dr.opaque(mi.Float, float(value)) for value in values]
        for values in (origin, np.float32(1) / np.asarray(size, np.float32), np.asarray(counts) - 0.5)
    )
    columns, rows = (dr.opaque(mi.UInt32, count) for count in counts[:2])
    x, y, z = (mi.UInt32(dr.clip((point[axis] - first[axis]) * per_unit[axis], 0, last[axis])) for axis in range(3))
    return x + columns * (y + rows * z)


def copied(size: int) -> int:
    """Power of two that holds so many elements: every thread adds to a copy, whose size stands in the kernel."""
    return 1 << max(0, size - 1).bit_length()


def pointer(shape: Any) -> Any:
    """A shape, or none, for comparison with hits, mi.ShapePtr; opaque: the compiled kernel serves any sensor."""
    found = mi.ShapePtr(shape)
    dr.make_opaque(found)
    return found


def columns(values: npt.NDArray[Any]) -> list[npt.NDArray[np.float32]]:
    """Each column of a matrix as such a copy, shape (rows,)."""
    return [aligned(column, np.float32) for column in values.T]


def floats(values: npt.ArrayLike) -> Any:
    """Such a copy of an array in a row, mi.Float of its size."""
    return mi.Float(aligned(values, np.float32).ravel())


class OfMesh:
    """What is made of a mesh as it is now, made anew where its vertices were replaced."""

    def __init__(self) -> None:
        self._positions, self._made = None, None

    def of(self, shape: Any, make: Callable[[Any], Any]) -> Any:
        """What `make` makes of this shape."""
        # It is no part of this: a method of whoever holds this would hold it in turn, and a scene that is no more used
        # would live on. Shapes that live change the numbers of others, so that all kernels were compiled anew.
        positions = mi.traverse(shape)["vertex_positions"]
        # Replaced vertices are another variable. The one kept here stays alive, so that its index is not used again; it
        # is a handle of our own, because what the mesh hands out follows the mesh.
        if self._positions is None or self._positions.index != positions.index:
            self._made, self._positions = make(shape), mi.Float(positions)
        return self._made


def in_rows(values: Any, kind: npt.DTypeLike = np.float64) -> npt.NDArray[Any]:
    """A vector of the renderer as an array of a kind, each of its elements a row, shape (elements, components).

    Components are taken over one by one. To make one array of them, the renderer writes how many elements there are
    into its kernel, and compiles it anew for each number of rays or pixels, which takes longer than most frames.
    """
    dr.eval(values)
    return np.array(np.broadcast_arrays(*[np.array(each) for each in values]), kind).T
