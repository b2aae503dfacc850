"""A stage of independent pieces, computed on many processes, each of which leaves one file."""

import json
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from magicsim.errors import OutputError
from magicsim.workers.attempt import FailureKind, Outcome, Prepare, bound_threads
from magicsim.workers.run_folder import log_failures
from magicsim.workers.tasks import run_tasks
from magicsim_experiments.study.protocol import PIECES, Workshop


@dataclass(frozen=True, slots=True, kw_only=True)
class PiecesStage:
    """Calls a function on every task; what it returns for task k is the content of `pieces/NAME/k`."""

    name: str
    function: Callable[[Any], bytes]
    """Importable by name; returns the content of the piece's file. A `MagicsimError` that it raises is a result too:
    the piece has none, and why."""
    tasks: Sequence[object]
    seconds: float
    """Rough time of a piece on one core [s]."""
    suffix: str = ".json"
    """End of the files' names."""
    prepare: Prepare | None = bound_threads
    """Called once in each process with its number of threads."""

    def core_seconds(self, processes: int) -> float:
        """Rough time on one core [s]."""
        return self.seconds * len(self.tasks)

    def is_done(self, folder: Path) -> bool:
        """Whether every piece is there, or why it is not."""
        return not any(self._is_open(folder, number) for number in range(len(self.tasks)))

    def owns(self, name: str) -> bool:
        """None of the files: the study's own list has them."""
        return False

    def run(self, workshop: Workshop) -> None:
        """Computes what is not there yet."""
        left = [number for number in range(len(self.tasks)) if self._is_open(workshop.folder, number)]
        lost = []
        tasks = ((number, self.tasks[number]) for number in left)
        with closing(run_tasks(self.function, tasks, workshop.options, prepare=self.prepare)) as outcomes:
            outcome: Outcome[bytes]
            for done, outcome in enumerate(outcomes if left else (), len(self.tasks) - len(left) + 1):
                log_failures(workshop.folder, self.name, outcome.key, outcome.failures)
                last = outcome.failures[-1] if outcome.failures else None
                if outcome.result is not None:
                    workshop.ledger.place(self._file(outcome.key), outcome.result)
                elif last is not None and last.kind is FailureKind.REFUSED:
                    content = json.dumps({"message": last.message}, indent=1) + "\n"
                    workshop.ledger.place(_refusal(self.name, outcome.key), content.encode())
                else:
                    lost.append(last.message if last is not None else "no result")
                workshop.tell(done / len(self.tasks), f"{self.name}: {done} of {len(self.tasks)}")
        if lost:
            msg = f"{len(lost)} pieces of '{self.name}' have no result ({lost[0]}); --resume tries them again"
            raise OutputError(msg)

    def _file(self, number: int) -> str:
        return f"{PIECES}/{self.name}/{number:05d}{self.suffix}"

    def _is_open(self, folder: Path, number: int) -> bool:
        return not ((folder / self._file(number)).is_file() or (folder / _refusal(self.name, number)).is_file())


def read_pieces(folder: Path, stage: PiecesStage) -> list[bytes | None]:
    """Content of every piece of a finished stage, in order; None where it was refused."""
    place = folder / PIECES / stage.name
    return [_content(place / f"{number:05d}{stage.suffix}") for number in range(len(stage.tasks))]


def read_refusals(folder: Path, stage: PiecesStage) -> dict[int, str]:
    """Why pieces of a finished stage have no content, by number."""
    found = {number: _content(folder / _refusal(stage.name, number)) for number in range(len(stage.tasks))}
    return {number: str(json.loads(content)["message"]) for number, content in found.items() if content is not None}


def _refusal(stage: str, number: int) -> str:
    return f"{PIECES}/{stage}/{number:05d}.refused.json"


def _content(path: Path) -> bytes | None:
    return path.read_bytes() if path.is_file() else None
