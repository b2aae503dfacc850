"""The part of a suite that fits into three minutes, and how long a suite takes."""

import time
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path

from magicsim.dataset.recipes.estimate import estimate_scene
from magicsim.evaluation.cases import Case, list_cases
from magicsim.evaluation.suite import SuiteConfig
from magicsim.evaluation.takes.footage import Footage, film_case, read_recordings
from magicsim.evaluation.takes.take import take_key

MOST_S = 180.0
"""Longest quick evaluation [s]."""
MARGIN = 1.3
"""How much longer than the longest so far another take may be."""
REST_S = 10.0
"""Longest stream at rest of a quick evaluation [s]."""


def quick_suite(suite: SuiteConfig) -> tuple[SuiteConfig, list[str]]:
    """A suite's standard condition alone, and what that leaves out.

    Args:
        suite: The whole of it.
    """
    blocks = [
        block.model_copy(update={"lights": block.lights[:1], "seeds": block.seeds[:1], "places": ()})
        for block in suite.episodes
        if block.lights[0] == suite.episodes[0].lights[0]
    ]
    rest = min(suite.rest_s, REST_S)
    quick = suite.model_copy(
        update={"episodes": tuple(blocks), "noises": suite.noises[:1], "rest_s": rest, "recordings": suite.recordings}
    )
    kept = {case.name for case in list_cases(quick)}
    gone = [case.name for case in list_cases(suite) if case.name not in kept]
    left_out = [f"take {name}" for name in gone]
    left_out += [f"noise {noise.name}" for noise in suite.noises[1:]]
    if rest < suite.rest_s:
        left_out.append(f"{suite.rest_s - rest:g} of {suite.rest_s:g} s at rest")
    return quick, left_out


def quick_films(suite: SuiteConfig, cache: Path, left_out: list[str], *, begun: float) -> Iterator[list[Footage]]:
    """Footage of one take after another, held-out objects and others in turn, as long as there is time.

    Args:
        suite: Of `quick_suite`.
        cache: Folder of takes.
        left_out: To which the takes are added that were not reached.
        begun: When the evaluation began, by `time.perf_counter`.
    """
    longest = 0.0
    for case in _in_turn(list_cases(suite)):
        now = time.perf_counter()
        if longest and now - begun + MARGIN * longest > MOST_S:
            left_out.append(f"take {case.name}")
            continue
        yield film_case(case, suite, cache)
        longest = max(longest, time.perf_counter() - now)
    for each in read_recordings(suite):
        yield [each]


def foretold_s(suite: SuiteConfig, cache: Path, cores: int) -> tuple[int, int, float]:
    """Takes to render, takes that are kept, and the time that the first need [s]; rough, within a factor of two or so.

    Args:
        suite: The episodes.
        cache: Folder of takes.
        cores: Cores to render on.
    """
    cases = list_cases(suite)
    wanted = [case for case in cases if not (cache / f"{take_key(case.scene)}.npz").is_file()]
    seconds = sum(estimate_scene(case.scene).seconds(cores) for case in wanted)
    return len(wanted), len(cases) - len(wanted), seconds


def _in_turn(cases: list[Case]) -> list[Case]:
    roles = {role: [case for case in cases if case.role == role] for role in ("held_out", "training")}
    pairs = zip_longest(roles["held_out"], roles["training"])
    return [case for pair in pairs for case in pair if case is not None]
