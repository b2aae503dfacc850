"""The search: batches of designs, each chosen in the knowledge of all before it, and the front of the best.

A batch is judged whole before its results are told, in the order of their numbers, so that neither the number of
workers nor their speed changes what is chosen. A run that goes on asks and tells all of it again, from the results
in the folder. Optuna, which this module alone needs, is loaded when a search begins.

Tree-structured Parzen estimators (Bergstra et al., NeurIPS 2011), for several objectives as of Ozaki et al. (J. Artif.
Intell. Res. 73, 2022), fitted to all fields together. Designs of the same batch that have no result yet count as bad
ones, so that a batch does not hold the same design many times.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from magicsim.arrays import Array, Mask
from magicsim.errors import ConfigError
from magicsim.folder.ledger import Ledger
from magicsim.sampling.distribution import unit_points
from magicsim.sweep.designs import POINTS, SweptDesign, design_with, values_at
from magicsim.sweep.result import DesignResult, finite, read_result, result_name
from magicsim.sweep.sweep_file import Objective, SearchSettings, SweepConfig


def costs_of(results: Sequence[DesignResult], objectives: Sequence[Objective]) -> Array:
    """What each design is to keep small, shape (designs, objectives); NaN where a measure has no value."""
    signs = [-1.0 if each.direction == "higher" else 1.0 for each in objectives]
    rows = []
    for result in results:
        measured = [result.measures.get(each.measure) for each in objectives]
        values = [np.nan if each is None or each.value is None else each.value for each in measured]
        rows.append([sign * value for sign, value in zip(signs, values, strict=True)])
    return np.array(rows, float).reshape(len(results), len(objectives))


def pareto_front(costs: Array) -> Mask:
    """Which designs no other one equals or beats in every objective and beats in one, shape (designs,)."""
    known = np.asarray(np.isfinite(costs).all(1) & (costs.shape[1] > 0))
    result = np.array(known)
    for index in np.flatnonzero(known):
        others = costs[known]
        beaten = (others <= costs[index]).all(1) & (others < costs[index]).any(1)
        result[index] = not beaten.any()
    return result


SAMPLER = 5
"""Stream of the sampler's seed."""


def optuna_version() -> str:
    """Version of the package that chooses.

    Raises:
        ConfigError: It is not installed.
    """
    try:
        import optuna
    except ImportError as error:
        msg = f"sampling = 'search' needs the package {error.name}: pip install 'magicsim[search]'"
        raise ConfigError(msg) from None
    return str(optuna.__version__)


class Study:
    """What was asked and told so far; the same results, told in the same order, lead to the same points."""

    def __init__(self, sweep: SweepConfig, settings: SearchSettings) -> None:
        """Begins without results."""
        import optuna

        self._sweep, self._settings, self._names = sweep, settings, [each.field for each in sweep.swept]
        self._open: list[optuna.Trial] = []
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        seed = int(np.random.SeedSequence([sweep.seed, SAMPLER]).generate_state(1)[0])
        sampler = optuna.samplers.TPESampler(seed=seed, n_startup_trials=settings.start, multivariate=True)
        self._study = optuna.create_study(directions=["minimize"] * len(sweep.objectives), sampler=sampler)
        points = unit_points(settings.start, len(self._names), seed=sweep.seed, stream=POINTS, sampling="sobol")
        for point in points.tolist():
            self._study.enqueue_trial(dict(zip(self._names, point, strict=True)))

    def ask(self, count: int) -> list[list[float]]:
        """Chooses the next points of the unit cube, one number in 0..1 for each swept field."""
        points = []
        for _ in range(count):
            trial = self._study.ask()
            points.append([trial.suggest_float(name, 0.0, 1.0) for name in self._names])
            self._open.append(trial)
        return points

    def tell(self, results: Sequence[DesignResult | None]) -> None:
        """What became of the points that were asked last, in their order; None for a design without a result.

        A design without a value of an objective or a limit has failed as well: nothing is learned from it.
        """
        import optuna

        for trial, result in zip(self._open, results, strict=True):
            costs = costs_of([result], self._sweep.objectives)[0] if result is not None else np.array([np.nan])
            excesses = [each.excess(result) if result is not None else None for each in self._settings.limits]
            if not np.isfinite(costs).all() or None in excesses:
                self._study.tell(trial, state=optuna.trial.TrialState.FAIL)
                continue
            for number, excess in enumerate(excesses):
                trial.set_constraint(str(number), float(excess or 0.0))
            self._study.tell(trial, costs.tolist())
        self._open = []


Failures = dict[str, str]
"""Why there is no result, by number of the design."""


def search_designs(
    sweep: SweepConfig,
    ledger: Ledger,
    judge: Callable[[list[SweptDesign], int, int], Failures],
    *,
    earlier: Mapping[str, str],
    record: Callable[[Failures], None],
) -> Failures:
    """Chooses and judges as many designs as the sweep counts.

    A design that is chosen again is not judged again: its first result counts. One that failed in a batch that was
    judged whole stays failed, because later designs were chosen in that knowledge.
    """
    settings, count = sweep.search or SearchSettings(), sweep.count or 1
    study, size = Study(sweep, settings), settings.batch
    failed: Failures = {}
    first_with: dict[tuple[float | str, ...], int] = {}
    results: dict[int, DesignResult | None] = {}
    is_replay = True
    for first in range(0, count, size):
        chosen = [values_at(sweep, point) for point in study.ask(min(size, count - first))]
        new: list[SweptDesign] = []
        for index, values in enumerate(chosen, first):
            if first_with.setdefault(tuple(values.values()), index) < index:
                ledger.remove(result_name(index))
                continue
            try:
                new.append(design_with(sweep, index, values))
            except ConfigError as error:
                failed[str(index)] = str(error)
        left = [each for each in new if _stored(ledger.out, each) is None]
        if is_replay:
            failed |= {str(each.index): earlier[str(each.index)] for each in left if str(each.index) in earlier}
            left = [each for each in left if str(each.index) not in earlier]
        if left:
            is_replay = False
            failed |= judge(left, first + len(chosen) - len(left), len(failed))
            record(failed)
        results |= {design.index: _stored(ledger.out, design) for design in new}
        study.tell([results.get(first_with[tuple(values.values())]) for values in chosen])
    return failed


def _stored(out: Path, design: SweptDesign) -> DesignResult | None:
    """A design's result in the folder; one of another design under the same number does not count."""
    result = read_result(out, design.index)
    return result if result is not None and result.values == finite(design.values) else None
