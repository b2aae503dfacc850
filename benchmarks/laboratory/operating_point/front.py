"""Which targets sensors meet together, and which exclude each other."""

from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import combinations

from laboratory.operating_point.targets import TARGETS, distances


def met(quantities: Mapping[str, float]) -> frozenset[str]:
    """Names of the targets that a sensor meets."""
    return frozenset(name for name, left in distances(quantities).items() if left == 0)


def exclusive(sensors: Iterable[frozenset[str]]) -> list[tuple[str, str]]:
    """Pairs of targets, each met by some sensor, that none meets together."""
    known = set(sensors)
    alone = frozenset().union(*known)
    return [
        (one, other)
        for one, other in combinations(TARGETS, 2)
        if {one, other} <= alone and not any({one, other} <= each for each in known)
    ]


def front(sensors: Iterable[frozenset[str]]) -> list[tuple[frozenset[str], int]]:
    """The Pareto front: sets of targets that no sensor widens, the largest first, and by how many each is met."""
    counted = Counter(sensors)
    widest = [each for each in counted if not any(each < other for other in counted)]
    return sorted(
        ((each, counted[each]) for each in widest), key=lambda entry: (-len(entry[0]), -entry[1], sorted(entry[0]))
    )
