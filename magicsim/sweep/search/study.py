"""The study of a search: chooses points of the unit cube, learns what became of them. The one module that needs Optuna.

Tree-structured Parzen estimators (Bergstra et al., NeurIPS 2011), for several objectives as of Ozaki et al. (J. Artif.
Intell. Res. 73, 2022), fitted to all fields together. Designs of the same batch that have no result yet count as bad
ones, so that a batch does not hold the same design many times.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from magicsim.errors import ConfigError
from magicsim.sampling.points import unit_points
from magicsim.sweep.designs import POINTS
from magicsim.sweep.result import DesignResult
from magicsim.sweep.search.pareto import costs_of
from magicsim.sweep.search.search_settings import SearchSettings
from magicsim.sweep.sweep_file import SweepConfig

if TYPE_CHECKING:
    import optuna

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


@dataclass(slots=True, kw_only=True)
class Study:
    """What was asked and told so far; the same results, told in the same order, lead to the same points."""

    sweep: SweepConfig
    _study: "optuna.Study" = field(init=False)
    _open: "list[optuna.Trial]" = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        """Begins without results."""
        import optuna

        names, settings = self._names(), self._settings()
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        seed = int(np.random.SeedSequence([self.sweep.seed, SAMPLER]).generate_state(1)[0])
        sampler = optuna.samplers.TPESampler(seed=seed, n_startup_trials=settings.start, multivariate=True)
        self._study = optuna.create_study(directions=["minimize"] * len(self.sweep.objectives), sampler=sampler)
        for point in unit_points(
            settings.start, len(names), seed=self.sweep.seed, stream=POINTS, sampling="sobol"
        ).tolist():
            self._study.enqueue_trial(dict(zip(names, point, strict=True)))

    def ask(self, count: int) -> list[list[float]]:
        """Chooses the next points of the unit cube, one number in 0..1 for each swept field."""
        points = []
        for _ in range(count):
            trial = self._study.ask()
            points.append([trial.suggest_float(name, 0.0, 1.0) for name in self._names()])
            self._open.append(trial)
        return points

    def tell(self, results: Sequence[DesignResult | None]) -> None:
        """What became of the points that were asked last, in their order; None for a design without a result.

        A design without a value of an objective or a limit has failed as well: nothing is learned from it.
        """
        import optuna

        for trial, result in zip(self._open, results, strict=True):
            costs = costs_of([result], self.sweep.objectives)[0] if result is not None else np.array([np.nan])
            excesses = [each.excess(result) if result is not None else None for each in self._settings().limits]
            if not np.isfinite(costs).all() or None in excesses:
                self._study.tell(trial, state=optuna.trial.TrialState.FAIL)
                continue
            for number, excess in enumerate(excesses):
                trial.set_constraint(str(number), float(excess or 0.0))
            self._study.tell(trial, costs.tolist())
        self._open = []

    def _names(self) -> list[str]:
        return [each.field for each in self.sweep.swept]

    def _settings(self) -> SearchSettings:
        return self.sweep.search or SearchSettings()
