"""How tasks are spread over processes."""

import os
from dataclasses import dataclass

from magicsim.config.ranges import check_number
from magicsim.errors import ConfigError

MAX_WORKERS = 1024
"""Each is a process with the renderer in it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkerOptions:
    """Nothing here changes a result: only where and when it is computed."""

    workers: int
    """Processes on this machine; ignored with a cluster, which brings its own."""
    timeout_s: float | None = None
    """Longest time for one attempt [s]; None waits for ever."""
    retries: int = 2
    """Further attempts after a crash, a timeout or an unexpected error."""
    max_tasks: int = 50
    """Tasks after which a process is replaced by a fresh one; 0 means never."""
    cluster: str | None = None
    """Address of a running dask.distributed scheduler, or None for this machine."""

    @property
    def threads(self) -> int:
        """Threads for each process on this machine."""
        return max(1, usable_cores() // self.workers)


def usable_cores() -> int:
    """Cores that this process may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def choose_workers(
    workers: int | None, *, cluster: str | None = None, timeout_s: float | None = None, retries: int = 2
) -> WorkerOptions:
    """Options from what a user asked for.

    Args:
        workers: Processes on this machine; one for each core by default.
        cluster: Address of a dask.distributed scheduler.
        timeout_s: Longest time for one attempt [s].
        retries: Further attempts after a failure that may pass.

    Raises:
        ConfigError: A number is not allowed, or both workers and a cluster were named.
    """
    if workers is not None:
        check_number("workers", workers, 1, MAX_WORKERS, whole=True)
    if workers is not None and cluster is not None:
        raise ConfigError(f"workers = {workers} is not allowed with a cluster, which has workers of its own")
    if cluster is not None and "://" not in cluster:
        raise ConfigError(f"cluster = '{cluster}' is not allowed: must be an address such as tcp://scheduler:8786")
    return WorkerOptions(workers=workers or usable_cores(), cluster=cluster, timeout_s=timeout_s, retries=retries)
