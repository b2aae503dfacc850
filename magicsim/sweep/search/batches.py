"""The search: batches of designs, each chosen in the knowledge of all before it.

A batch is judged whole before its results are told, in the order of their numbers, so that neither the number of
workers nor their speed changes what is chosen. A run that goes on asks and tells all of it again, from the results
in the folder.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

from magicsim.errors import ConfigError
from magicsim.folder.ledger import Ledger
from magicsim.sweep.designs import SweptDesign, design_with, values_at
from magicsim.sweep.folder import read_result, result_name
from magicsim.sweep.result import DesignResult, finite
from magicsim.sweep.search.search_settings import SearchSettings
from magicsim.sweep.search.study import Study
from magicsim.sweep.sweep_file import SweepConfig

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

    Args:
        sweep: What to search.
        ledger: Of the folder of the results.
        judge: Judges new designs, told how many ended and how many failed before them; places their results in the
            folder and returns who failed.
        earlier: What `record` was told last in an earlier run.
        record: Told who failed so far, after every batch that was judged.
    """
    study, count, size = Study(sweep=sweep), sweep.count or 1, (sweep.search or SearchSettings()).batch
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
        left = []
        for design in new:
            if _stored(ledger.out, design) is None and is_replay and str(design.index) in earlier:
                failed[str(design.index)] = earlier[str(design.index)]
            elif _stored(ledger.out, design) is None:
                left.append(design)
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
