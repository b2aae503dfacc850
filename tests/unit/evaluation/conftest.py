"""One tiny suite with its cache, and the built-in detectors with thresholds that suit it."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from magicsim.evaluation.answers import judge_footage
from magicsim.evaluation.baseline import Baseline, load_baseline, save_baseline
from magicsim.evaluation.detector import MakeDetector, ProfileDetector
from magicsim.evaluation.evaluate import Evaluation, evaluate_suite, film_suite
from magicsim.evaluation.suite import SuiteConfig
from magicsim.judge.tally import JudgedEpisode

from .synthetic import PROFILE, make_suite


def built_in(**changes: object) -> MakeDetector:
    profile = replace(PROFILE, **changes)
    return lambda: ProfileDetector(profile)


@pytest.fixture(scope="package")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> tuple[SuiteConfig, Path]:
    return make_suite(tmp_path_factory.mktemp("suite"))


@pytest.fixture(scope="package")
def evaluate(tiny: tuple[SuiteConfig, Path]) -> Callable[..., Evaluation]:
    suite, cache = tiny

    def run(
        make: MakeDetector | None = None, baseline: Baseline | None = None, seed: int = 0, **changes: object
    ) -> Evaluation:
        return evaluate_suite(
            suite.model_copy(update={"seed": seed}), make or built_in(**changes), name="tiny", detector="built-in",
            cache=cache, baseline=baseline,
        )  # fmt: skip

    return run


@pytest.fixture(scope="package")
def judge(tiny: tuple[SuiteConfig, Path]) -> Callable[..., list[JudgedEpisode]]:
    """Verdicts alone, without measures."""
    suite, cache = tiny

    def run(make: MakeDetector | None = None, seed: int = 0, **changes: object) -> list[JudgedEpisode]:
        seeded = suite.model_copy(update={"seed": seed})
        films = [film for take in film_suite(seeded, cache) for film in take]
        return [judge_footage(film, make or built_in(**changes), who="built-in") for film in films]

    return run


@pytest.fixture(scope="package")
def found(evaluate: Callable[..., Evaluation]) -> Evaluation:
    return evaluate()


@pytest.fixture(scope="package")
def worse(evaluate: Callable[..., Evaluation], found: Evaluation, tmp_path_factory: pytest.TempPathFactory):
    path = tmp_path_factory.mktemp("page") / "baseline.json"
    save_baseline(path, found.episodes, suite="tiny", detector="built-in")
    return evaluate(tau_g=0.6, baseline=load_baseline(path))
