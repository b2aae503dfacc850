"""The registry: a variation is a function of an empty folder that says what went wrong, or nothing."""

import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

REFUSED = 2
"""Exit code of a command that ends with one line."""
Attempt = Callable[[Path], str | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Variation:
    """One form of a kind."""

    name: str
    expected: str
    """The right value, or what the one line names."""
    attempt: Attempt
    """Tries it in an empty folder; says what went wrong, None where nothing did."""


KINDS: dict[str, list[Variation]] = defaultdict(list)
"""Variations by kind, in the order of their modules."""


def variation(kind: str, name: str, *, expected: str) -> Callable[[Attempt], Attempt]:
    """Puts a function into the registry."""

    def register(attempt: Attempt) -> Attempt:
        KINDS[kind].append(Variation(name=name, expected=expected, attempt=attempt))
        return attempt

    return register


def run(
    *words: str, folder: Path, environment: Mapping[str, str | None] | None = None, timeout_s: float = 300
) -> subprocess.CompletedProcess[str]:
    """Runs this Python with some words in a folder: `-m magicsim ...`, `-c ...`; `None` takes a variable away."""
    import os

    import magicsim

    given = {**os.environ, "PYTHONPATH": str(Path(magicsim.__file__).parents[1]), **(environment or {})}
    return subprocess.run(
        [sys.executable, *words], cwd=folder, capture_output=True, text=True, timeout=timeout_s, check=False,
        env={name: value for name, value in given.items() if value is not None},
    )  # fmt: skip


def one_line_with(ended: subprocess.CompletedProcess[str], *words: str) -> str | None:
    """What is wrong with the end of a command that should refuse in one line that holds some words."""
    lines = ended.stderr.strip().splitlines()
    if ended.returncode != REFUSED or "Traceback" in ended.stderr or not lines:
        return f"exit code {ended.returncode}: {ended.stderr[-300:]}"
    missing = [word for word in words if word not in lines[-1]]
    return f"without {missing}: {lines[-1]}" if missing else None
