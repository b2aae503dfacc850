"""A limit in processor seconds, so that what is out of time does not depend on who else uses the machine."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager


class OutOfProcessorTimeError(Exception):
    """What ran has used up its processor time."""


@contextmanager
def processor_limit(seconds: float) -> Iterator[None]:
    """Ends what runs inside after processor seconds of this process; in its main thread, on Unix.

    Args:
        seconds: Of all threads together [s].

    Raises:
        OutOfProcessorTimeError: Between two instructions of Python, so that a long call of a library ends first.
    """

    def stop(*_: object) -> None:
        msg = f"took longer than {seconds:g} s of processor time"
        raise OutOfProcessorTimeError(msg)

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
