"""The folder that a sweep grows in: one file a design, whole or not there, and what they belong to."""

import json
from pathlib import Path

import tomli_w
from pydantic import Field

from magicsim.config import Config, validate
from magicsim.errors import OutputError
from magicsim.sweep.result import DesignResult
from magicsim.sweep.sweep_file import SweepConfig
from magicsim.workers.folder import ERRORS, WORK, place
from magicsim.workers.versions import changed_versions

INDEX, CONFIG, DESIGNS, REPORT = "sweep.json", "config.toml", "designs", "report.html"
CSV, PARQUET, FRAMES = "sweep.csv", "sweep.parquet", "frames"


class SweepIndex(Config):
    """What a folder's results belong to."""

    schema_version: int = 1
    config_hash: str
    """SHA-256 of what results depend on (`SweepConfig.config_hash`)."""
    versions: dict[str, str]
    variant: str
    designs: int
    is_complete: bool = False
    failed: dict[str, str] = Field(default_factory=dict)
    """Why there is no result, by number of the design."""


def check_folder(out: Path, *, resume: bool) -> None:
    """Refuses a folder that is not ours, or holds a sweep that nobody asked to go on with.

    Raises:
        OutputError: With what to do instead.
    """
    if out.exists() and not out.is_dir():
        msg = f"output folder '{out}' is a file; name a new folder"
        raise OutputError(msg)
    index = read_index(out)
    if index is None and out.is_dir() and {path.name for path in out.iterdir()} - {WORK, ERRORS}:
        msg = f"output folder '{out}' holds other files; name a new or empty folder"
        raise OutputError(msg)
    if index is not None and not resume and any((out / DESIGNS).glob("*.json")):
        state = "a" if index.is_complete else "an unfinished"
        msg = f"output folder '{out}' holds {state} sweep already; --resume goes on with it"
        raise OutputError(msg)


def read_index(out: Path) -> SweepIndex | None:
    """The index of a folder, None where there is none.

    Raises:
        OutputError: It is not one that this version understands.
    """
    path = out / INDEX
    if not path.is_file():
        return None
    try:
        return validate(SweepIndex, json.loads(path.read_text(encoding="utf-8")), source=INDEX)
    except (ValueError, OSError) as error:
        msg = f"'{path}' is not an index of a sweep: {error}"
        raise OutputError(msg) from None


def write_index(out: Path, index: SweepIndex) -> None:
    """Replaces the index at once."""
    place(out / INDEX, (json.dumps(index.model_dump(mode="json"), indent=1) + "\n").encode())


def write_config(out: Path, sweep: SweepConfig) -> None:
    """Writes the sweep with everything in place."""
    config = tomli_w.dumps(sweep.model_dump(mode="json", exclude_none=True))
    place(out / CONFIG, f"# A sweep of magicsim, everything in place: `magicsim sweep {CONFIG}`\n{config}".encode())


def result_path(out: Path, index: int) -> Path:
    """Where a design's result lies."""
    return out / DESIGNS / f"{index:05d}.json"


def read_results(out: Path, count: int) -> list[DesignResult]:
    """All results of a sweep's designs, in order; what cannot be read is not there."""
    return [result for index in range(count) if (result := read_result(out, index)) is not None]


def read_result(out: Path, index: int) -> DesignResult | None:
    """A design's result, None without one; one that cannot be read is removed."""
    path = result_path(out, index)
    try:
        return DesignResult.from_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except (ValueError, KeyError, TypeError):
        path.unlink()
        return None


def refuse_another(out: Path, earlier: SweepIndex, now: SweepIndex) -> None:
    """Refuses to go on with another sweep's results.

    Raises:
        OutputError: With what differs.
    """
    if earlier.config_hash != now.config_hash:
        msg = f"'{out}' holds another sweep (see its {CONFIG}); name another folder"
        raise OutputError(msg)
    changed = changed_versions(earlier.versions | {"variant": earlier.variant}, now.versions | {"variant": now.variant})
    if changed:
        msg = f"'{out}' was begun with another version of {', '.join(changed)}: its results would differ"
        raise OutputError(msg)
