import pytest

from magicsim.errors import ConfigError
from magicsim.workers.attempt import WorkerOptions, choose_workers, usable_cores


def test_processes_share_the_cores():
    assert choose_workers(None).workers == usable_cores()
    assert WorkerOptions(workers=1).threads == usable_cores()
    assert WorkerOptions(workers=10 * usable_cores()).threads == 1


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"workers": 0}, "workers = 0 is not allowed: must be a whole number of at least 1 and at most 1024"),
        ({"workers": 2, "cluster": "tcp://a:1"}, "workers = 2 is not allowed with a cluster"),
        ({"workers": None, "cluster": "a"}, "cluster = 'a' is not allowed: must be an address"),
    ],
)
def test_what_cannot_be_used_is_refused(options, named):
    with pytest.raises(ConfigError, match=named):
        choose_workers(**options)
