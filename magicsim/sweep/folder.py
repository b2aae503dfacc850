"""The folder that a sweep grows in: one file a design, whole or not there, and what they belong to."""

from pathlib import Path

from pydantic import Field

from magicsim.errors import OutputError
from magicsim.sweep.result import DesignResult
from magicsim.workers.run_folder import CONFIG, RunFolder, RunIndex

INDEX, DESIGNS, REPORT = "sweep.json", "designs", "report.html"
CSV, PARQUET, FRAMES = "sweep.csv", "sweep.parquet", "frames"


class SweepIndex(RunIndex):
    """What a folder's results belong to."""

    designs: int
    failed: dict[str, str] = Field(default_factory=dict)
    """Why there is no result, by number of the design."""


def _has_results(out: Path) -> bool:
    return any((out / DESIGNS).glob("*.json"))


FOLDER = RunFolder(
    index=INDEX, model=SweepIndex, noun="sweep", content="sweep", asks_to_resume=_has_results,
    title=f"A sweep of magicsim, everything in place: `magicsim sweep {CONFIG}`",
)  # fmt: skip


def result_name(index: int) -> str:
    """Name of a design's result below the folder."""
    return f"{DESIGNS}/{index:05d}.json"


def read_results(out: Path, count: int) -> list[DesignResult]:
    """All results of a sweep's designs, in order; a design without one is left out."""
    return [result for index in range(count) if (result := read_result(out, index)) is not None]


def read_result(out: Path, index: int) -> DesignResult | None:
    """A design's result, None without one.

    Raises:
        OutputError: It cannot be read.
    """
    path = out / result_name(index)
    try:
        return DesignResult.from_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except (ValueError, KeyError, TypeError) as error:
        msg = f"'{path}' is not a result of a sweep: {error}; without it, --resume judges the design again"
        raise OutputError(msg) from None
