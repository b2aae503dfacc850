"""What the processes of these tests run: importable by name."""

import os
import signal
import time
from pathlib import Path

from magicsim.errors import GeometryError


def square(number: int) -> int:
    return number * number


def refuse(number: int) -> int:
    msg = f"number = {number} is not allowed"
    raise GeometryError(msg)


def fail_at_first(task: tuple[str, int]) -> int:
    """Notes each attempt as a file; what goes wrong in the first ones is in the name of the task."""
    folder, number = task
    earlier = len(list(Path(folder).glob(f"{number}-*")))
    (Path(folder) / f"{number}-{earlier}").touch()
    if number == 1 and earlier == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    if number == 2 and earlier < 2:
        msg = "weather"
        raise RuntimeError(msg)
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    if number == 4 and earlier == 0:
        time.sleep(60)
    return number


def process_and_threads(_: int) -> tuple[int, str]:
    return os.getpid(), os.environ["OMP_NUM_THREADS"] + os.environ.get("PREPARED", "")


def prepare(threads: int) -> None:
    os.environ["PREPARED"] = f" and {threads}"


def not_to_be_sent(_: int) -> object:
    return lambda: None
