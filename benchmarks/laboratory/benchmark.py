"""A benchmark answers one question with rows in a JSON file, and draws its plot from that file and nothing else."""

import argparse
import json
import logging
import os
import platform
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from matplotlib.figure import Figure

from magicsim.config.documents import read_json
from magicsim.errors import MagicsimError
from magicsim.folder import check_file, result_file

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Row = TypeVar("Row", bound="DataclassInstance")
LOGGER = logging.getLogger(__name__)
PACKAGES = ("magicsim", "numpy", "scipy", "pypardiso", "felupe", "ngsolve")


@dataclass(frozen=True, slots=True, kw_only=True)
class Benchmark:
    """A question, how to answer it and how to draw the answer."""

    run: Callable[..., dict[str, Any]]
    """Takes `quick`; returns an object with `kind` and `results`."""
    plot: Callable[[dict[str, Any], Path], None]

    def answer(self, kind: str, out: Path, **options: Any) -> dict[str, Any]:  # noqa: ANN401
        """Runs the benchmark; `out` then holds `bench-KIND.json` and `bench-KIND.png`.

        Args:
            kind: Name of the question.
            out: Folder, made where missing.
            options: What `run` takes.

        Raises:
            OutputError: The folder cannot be written; that is told before anything is measured.
        """
        file = out / f"bench-{kind}.json"
        check_file(file)
        data = self.run(**options)
        with result_file(file) as partial:
            partial.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
        self.plot(read_json(file), out / f"bench-{kind}.png")
        return data


def script_parser(description: str | None) -> argparse.ArgumentParser:
    """The options that every benchmark takes, `--out` and `--quick`; rows are logged as they are measured."""
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    logging.getLogger("laboratory").setLevel(logging.INFO)
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("magicsim-bench"), help="folder of the JSON file and the plot")
    parser.add_argument("--quick", action="store_true", help="a small part of it")
    return parser


@contextmanager
def one_line_errors(parser: argparse.ArgumentParser) -> Iterator[None]:
    """Ends a script with one line, exit 2, where the simulator refuses something."""
    try:
        yield
    except MagicsimError as error:
        parser.exit(2, f"error: {error}\n")


def logged(rows: Iterable[Row]) -> list[Row]:
    """All rows; each is a line of the log once it is there, as some benchmarks take an hour: texts and numbers by name.

    Args:
        rows: Dataclasses, made one after the other.
    """
    kept = []
    for row in rows:
        LOGGER.info("%s", ", ".join(_figures(asdict(row))))
        kept.append(row)
    return kept


def _figures(row: dict[str, Any]) -> Iterable[str]:
    for name, value in row.items():
        if isinstance(value, str | bool | int) or value is None:
            yield f"{name} {value}"
        elif isinstance(value, float):
            yield f"{name} {value:.4g}"


def machine() -> dict[str, Any]:
    """System, cores and versions of packages, on which figures were measured."""
    return {
        "platform": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "packages": {name: _version(name) for name in PACKAGES},
    }


def save_figure(figure: Figure, target: Path) -> None:
    """Writes a figure, the same bytes for the same figure."""
    with result_file(target) as partial:
        metadata = {"Software": None} if target.suffix == ".png" else {"Date": None}
        figure.savefig(partial, dpi=90, metadata=metadata)


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
