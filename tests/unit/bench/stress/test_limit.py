"""What computes is ended, what waits is not."""

import signal
import time

import pytest

from magicsim.bench.stress.limit import OutOfProcessorTimeError, processor_limit


def test_what_computes_is_ended_within_its_processor_time():
    begun = time.process_time()
    with pytest.raises(OutOfProcessorTimeError, match=r"0\.05 s of processor time"), processor_limit(0.05):
        _compute(5.0)
    assert 0.04 <= time.process_time() - begun < 5.0


def test_waiting_takes_no_processor_time():
    with processor_limit(0.2):
        time.sleep(0.4)


def test_the_limit_ends_with_its_block_and_the_former_handler_is_back():
    before = signal.getsignal(signal.SIGPROF)
    with processor_limit(0.05):
        pass
    assert signal.getsignal(signal.SIGPROF) is before
    _compute(0.1)


def _compute(seconds):
    until = time.process_time() + seconds
    while time.process_time() < until:
        pass
