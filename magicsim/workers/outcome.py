"""What becomes of a task: its result, or why there is none."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

ResultT = TypeVar("ResultT")


class FailureKind(StrEnum):
    """Why a task has no result."""

    REFUSED = "refused"
    """It raised a `MagicsimError`: trying again would end the same way."""
    ERROR = "error"
    """It raised anything else."""
    CRASH = "crash"
    """Its process ended."""
    TIMEOUT = "timeout"
    """It took longer than allowed, and its process was ended."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """One failed attempt."""

    kind: FailureKind
    message: str
    """One line."""
    traceback: str = ""
    """Where it was raised, empty where nothing was."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome(Generic[ResultT]):
    """The end of one task."""

    key: int
    """Number of the task."""
    result: ResultT | None
    """What the function returned, None after the last failure."""
    failures: tuple[Failure, ...]
    """All failed attempts, in order; a task with a result may have some."""
    seconds: float
    """How long the successful attempt took in its process [s]; 0 without one."""

    @property
    def succeeded(self) -> bool:
        """Whether there is a result."""
        return self.result is not None
