"""Work on all cells in two halves, by two threads where there are two to use.

Sums over cells are always taken half by half, so that results do not depend on how many threads there are.
"""

from collections.abc import Callable
from threading import Thread

import numba as nb

FEWEST_CELLS = 1000
"""Cells below which a second thread costs more than it saves."""


def in_halves(work: Callable[[slice], None], count: int) -> None:
    """Calls a function that lets go of the interpreter's lock for each half of some cells.

    Args:
        work: Given the cells of a half; it writes nothing that the other half reads or writes, and does not raise.
        count: How many cells there are.
    """
    first, second = slice(0, count // 2), slice(count // 2, count)
    may_use_two = nb.config.NUMBA_NUM_THREADS > 1  # type: ignore[attr-defined]
    if count < FEWEST_CELLS or not may_use_two:
        work(first)
        work(second)
        return
    other = Thread(target=work, args=(second,))
    other.start()
    work(first)
    other.join()
