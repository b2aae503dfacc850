"""The command that judges detectors: `evaluate`."""

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, app, print_result
from magicsim.errors import ConfigError

REGRESSED = 1
"""Exit code where a measure fell significantly against the baseline."""


@app.command
def evaluate(
    suite: str = "small", *, profile: str = "calibrated",
    detector: Annotated[str | None, Parameter(help="module:Class, file.py:Class or an entry point's name.")] = None,
    baseline: Annotated[Path | None, Parameter(help="What to compare with; the shipped one by default.")] = None,
    save_baseline: Annotated[Path | None, Parameter(help="Where to keep these verdicts as a baseline.")] = None,
    out: Out = Path("magicsim-evaluate"),
    cache: Annotated[Path, Parameter(help="Folder of rendered episodes.")] = Path("magicsim-takes"),
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Judge a detector on a suite of labelled episodes; exit code 1 where it is worse than the baseline.

    --seed draws other camera noise of the same episodes, which needs no new rendering.
    """
    from magicsim.evaluation.baseline import default_baseline, load_baseline
    from magicsim.evaluation.baseline import save_baseline as keep
    from magicsim.evaluation.detector import built_in, find_detector
    from magicsim.evaluation.suite import load_suite
    from magicsim.folder import check_target

    if detector is not None and profile != "calibrated":
        msg = f"--profile {profile} is not allowed with --detector: a profile belongs to the built-in detectors"
        raise ConfigError(msg)
    config = load_suite(suite, settings or [], seed=seed)
    make = find_detector(detector) if detector is not None else built_in(profile)
    file = baseline or (default_baseline(suite, profile) if detector is None else None)
    known = load_baseline(file) if file is not None else None
    check_target(out)
    from magicsim.cli.progress import show_progress
    from magicsim.evaluation.evaluate import evaluate_suite
    from magicsim.evaluation.pages.report import describe, write_results

    name = Path(suite).stem
    with show_progress(f"evaluate {name}") as progress:
        found = evaluate_suite(
            config, make, name=name, detector=detector or profile, cache=cache, baseline=known, progress=progress
        )
    report = write_results(found, config, out)
    if save_baseline is not None:
        keep(save_baseline, found.episodes, suite=name, detector=found.detector)
    if json:
        print_result(found.as_dict() | {"report": str(report)}, as_json=True)
    else:
        sys.stdout.write("\n".join([*describe(found), f"report: {report}", ""]))
    if found.regressions:
        sys.exit(REGRESSED)
