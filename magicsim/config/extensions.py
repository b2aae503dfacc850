"""Commands, presets and schemas that a distribution beside this one adds by its entry points."""

from functools import cache
from importlib.metadata import EntryPoint, entry_points

COMMANDS, PRESETS, SCHEMAS = "magicsim.commands", "magicsim.presets", "magicsim.schemas"
"""Groups of entry points: a function or an `App` for each command, a folder (`pathlib.Path`) for each kind of preset,
and a function that returns a JSON Schema for each kind of file."""
EXPERIMENTS = frozenset({"study", "studies", "item", "items", "estimate", "task"})
"""Words that `magicsim-experiments` adds."""


@cache
def extensions(group: str) -> dict[str, EntryPoint]:
    """What other distributions add to a group, by name."""
    return {point.name: point for point in entry_points(group=group)}


def missing_experiments(word: str) -> str:
    """The line about a word of `EXPERIMENTS` where `magicsim-experiments` is not installed."""
    return f"'{word}' comes with magicsim-experiments, which is not installed: pip install ./benchmarks/experiments"
