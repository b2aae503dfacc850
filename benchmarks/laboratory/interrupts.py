"""Actions that are interrupted before a line of the package runs, as Ctrl-C or a lack of memory would.

A script is a sequence of steps that each say what they came to. One of them interrupted anywhere and then asked for
again has to come to the very bytes of a script that nothing has interrupted, and so have the steps after it.
"""

import ast
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

import magicsim

PACKAGE = str(Path(magicsim.__file__).parent)
Place = tuple[str, int]
"""File and line."""
Step = Callable[[], bytes]
Errors = Sequence[type[BaseException]]
ERRORS: Errors = (KeyboardInterrupt, MemoryError)


def watched(action: Callable[[], object], heard: Callable[[Place], None]) -> object:
    """Does something while every line of the package is told before it runs."""

    def trace(frame: FrameType, event: str, _: object) -> Any:  # noqa: ANN401 - itself
        if not frame.f_code.co_filename.startswith(PACKAGE):
            return None
        if event == "line":
            heard((frame.f_code.co_filename, frame.f_lineno))
        return trace

    earlier = sys.gettrace()
    sys.settrace(trace)
    try:
        return action()
    finally:
        sys.settrace(earlier)


def interrupt(action: Callable[[], object], place: Place, nth: int, error: type[BaseException]) -> bool:
    """Raises an error the nth time that a line is about to run; says whether it ended the action."""
    met = 0

    def stop(line: Place) -> None:
        nonlocal met
        met += line == place
        if line == place and met == nth:
            raise error

    try:
        watched(action, stop)
    except error:
        return True
    return False


@cache
def keeping(path: str) -> frozenset[int]:
    """Lines of the functions of a file that write to what outlives them: attributes, and what these hold.

    All others compute: interrupted there, whatever called them was interrupted at its call.
    """
    lines: set[int] = set()
    for node in ast.walk(ast.parse(Path(path).read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef) and node.name not in BIRTH and any(map(_writes, ast.walk(node))):
            lines.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return frozenset(lines)


BIRTH = {"__init__", "__post_init__"}
"""What these write to nobody else has yet."""
CHANGES = {"add", "append", "clear", "extend", "move_to_end", "pop", "popitem", "setdefault", "update"}


def _writes(node: ast.AST) -> bool:
    if isinstance(node, ast.Attribute | ast.Subscript) and isinstance(node.ctx, ast.Store | ast.Del):
        return isinstance(node, ast.Attribute) or isinstance(node.value, ast.Attribute)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in CHANGES:
        return isinstance(node.func.value, ast.Attribute)
    return False


def chosen(
    counts: Sequence[Counter[Place]], most: int | None, seed: int, within: str = ""
) -> list[list[tuple[Place, int]]]:
    """Lines to interrupt each step before, and which of the times that they run.

    Args:
        counts: How often each line runs in each step.
        most: So many lines of each step, drawn by the seed, half of them of functions that keep something. None is
            every line of those, the first time or the last, in turn, in one of the steps that it runs in.
        seed: Of the draw.
        within: Folder of the package whose lines are meant by every line.
    """
    random = np.random.default_rng(seed)
    found: list[list[tuple[Place, int]]] = [[] for _ in counts]
    if most is None:
        every = {each for count in counts for each in count if each[0].startswith(f"{PACKAGE}/{within}")}
        for turn, place in enumerate(sorted(each for each in every if each[1] in keeping(each[0]))):
            where = [number for number, count in enumerate(counts) if place in count]
            fewest = min(where, key=lambda number: len(found[number]))
            found[fewest].append((place, counts[fewest][place] if turn % 2 else 1))
        return found
    for step, count in zip(found, counts, strict=True):
        kept = [each for each in count if each[1] in keeping(each[0])]
        for number in range(most):
            among = kept if number % 2 and kept else list(count)
            place = among[random.integers(len(among))]
            step.append((place, int(random.integers(count[place])) + 1))
    return found


def differences(
    steps: Mapping[str, Step], *, most: int | None, seed: int = 0, errors: Errors = ERRORS, within: str = ""
) -> list[str]:
    """Where a script comes to something else once one of its steps was interrupted; the first step begins anew.

    Every turn of the script interrupts each of its steps before one line, and the last turn none.

    Args:
        steps: The script, by names of its steps; each gives the bytes of what it came to.
        most: Lines of each step, see `chosen`.
        seed: Of the draw.
        errors: What is raised, in turn.
        within: Folder of the package, see `chosen`.
    """
    wanted, counts, found = {name: step() for name, step in steps.items()}, [], []
    for name, step in steps.items():
        counts.append(Counter[Place]())
        if watched(step, lambda place, count=counts[-1]: count.update((place,))) != wanted[name]:  # type: ignore[misc]
            found.append(f"{name} does not repeat to the byte")
    places = dict(zip(steps, chosen(counts, most, seed, within), strict=True))
    for turn in range(max(map(len, places.values())) + 1):
        last = "nothing"
        for name, step in steps.items():
            if turn < len(places[name]):
                (path, line), nth = places[name][turn]
                error = errors[(turn + nth) % len(errors)]
                last = f"{error.__name__} in {name} at {Path(path).name}:{line}, time {nth}"
                interrupt(step, (path, line), nth, error)
            if step() != wanted[name]:
                found.append(f"{name} differs after {last}")
    return found
