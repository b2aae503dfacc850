"""The commands that judge: `detect` and `evaluate`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, app, print_result, refuse_settings
from magicsim.errors import ConfigError
from magicsim.folder.kept import TAKES

if TYPE_CHECKING:
    from magicsim.evaluation.evaluate import Evaluation
    from magicsim.evaluation.footage import Footage
    from magicsim.evaluation.suite import SuiteConfig

REGRESSED, UNJUDGED = 1, 3
"""Exit codes where a measure fell or a class collapsed, and where no fall against a baseline could have been found."""


@app.command
def detect(
    source: Path, *,
    reference: Annotated[Path | None, Parameter(help="Frames of the untouched sensor.")] = None,
    touches: Annotated[Path | None, Parameter(help="Frames of the sensor's own first touches.")] = None,
    profile: str = "calibrated", frames: int | None = None, grasp: bool = False,
    seed: Seed = None, settings: Settings = None, json: Json = False,
) -> None:  # fmt: skip
    """Run the detectors on an image, a folder of images, a video, a camera (by its index), a run or a dataset.

    A run of `simulate`, a dataset and a recording with a truth.csv bring their own references.
    --frames judges so many frames at most; a camera runs until it is interrupted without it. --grasp runs the grasp
    state machine over the frames and adds its `stage` and `slip` to each. --touches sets the threshold of a profile in
    units of rest, such as rest-relative, by the sensor's own first one to three touches.
    """
    from magicsim.detectors.offline import write_verdicts
    from magicsim.detectors.video import quiet_opencv

    refuse_settings(settings, "detect", "; write a profile file and name it with --profile")
    if touches is not None and reference is None:
        raise ConfigError("--touches is not allowed without --reference: name the untouched sensor's frames too")
    if reference is None:
        from magicsim.evaluation.existing import is_existing, write_existing_verdicts

        if not is_existing(source):
            msg = f"--reference is missing: '{source}' is no run, dataset or recording with untouched frames of its own"
            raise ConfigError(msg)
        write_existing_verdicts(sys.stdout, source, profile, frames=frames, grasp=grasp, as_json=json)
        return
    with quiet_opencv():  # a broken image is reported once, by us
        write_verdicts(
            sys.stdout, source, reference, profile, frames=frames, touches=touches, grasp=grasp, as_json=json
        )


@app.command
def evaluate(
    suite: str = "small", *, profile: str = "calibrated",
    detector: Annotated[str | None, Parameter(help="module:Class, file.py:Class or an entry point's name.")] = None,
    baseline: Annotated[Path | None, Parameter(help="What to compare with; the shipped one, if any.")] = None,
    save_baseline: Annotated[Path | None, Parameter(help="Where to keep these verdicts as a baseline.")] = None,
    quick: Annotated[bool, Parameter(negative="", help="A small part; of `small` it comes with the program.")] = False,
    allow_weak: Annotated[bool, Parameter(negative="", help="Too few takes for any verdict are no error.")] = False,
    on: Annotated[Path | None, Parameter(help="Judge frames that exist: a run, a dataset, or a recording.")] = None,
    out: Out = Path("magicsim-evaluate"),
    junit: Annotated[Path | None, Parameter(help="Where to write the verdicts for a build server (XML).")] = None,
    cache: Annotated[Path, Parameter(help="Folder of rendered episodes.")] = TAKES,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Judge a detector on a suite of labelled episodes; exit code 1 where it is worse than the baseline.

    Exit code 1 is also that of a class that is never named and of accuracies by chance, unless the baseline has that
    too; 3 is that of a baseline with which too few takes are shared for any fall to be found.

    --seed draws other camera noise of the same episodes, which needs no new rendering. --on renders nothing at all: a
    detector of your own is judged there in seconds.
    """
    from magicsim.evaluation import baseline as kept
    from magicsim.evaluation.detector import built_in, find_detector
    from magicsim.evaluation.suite import QUICK, SHIPPED, load_suite, refuse_settings_of_frames
    from magicsim.folder import check_file, check_target

    if detector is not None and profile != "calibrated":
        msg = f"--profile {profile} is not allowed with --detector: a profile belongs to the built-in detectors"
        raise ConfigError(msg)
    if quick and on is not None:
        raise ConfigError("--quick is not allowed with --on: frames that exist need no rendering")
    is_shipped = quick and suite == SHIPPED
    refuse_settings_of_frames(settings or [], quick=is_shipped, existing=on is not None)
    config = load_suite(suite, settings or [], seed=seed)
    make = built_in(profile) if detector is None else find_detector(detector)
    make()  # what cannot be made is told before anything is rendered
    check_target(out)
    for target in (save_baseline, junit):
        if target is not None:
            check_file(target)
    name = str(on) if on is not None else QUICK if is_shipped else Path(suite).stem
    if baseline is None and detector is None and on is None and quick is is_shipped:
        baseline = kept.default_baseline(name, profile)
        if save_baseline is not None and baseline == save_baseline.resolve():
            baseline = None  # it is made anew, whatever it holds
    known = kept.load_baseline(baseline) if baseline is not None else None
    from magicsim.cli.progress import show_progress
    from magicsim.evaluation.evaluate import evaluate_suite
    from magicsim.evaluation.page import describe, write_junit, write_results

    config, films, left_out = _chosen(config, on=on, quick=quick, is_shipped=is_shipped)
    if films is None:
        _foretell(config, cache)
    make = built_in(profile, is_coated=config.design.is_opaque) if detector is None else make
    with show_progress(f"evaluate {name}") as progress:
        found = evaluate_suite(
            config, make, name=name, detector=detector or profile, cache=cache, baseline=known, progress=progress,
            films=films,
        )  # fmt: skip
    report = write_results(found, config, out)
    if save_baseline is not None:
        kept.save_baseline(save_baseline, found.episodes, suite=name, detector=found.detector)
    if junit is not None:
        write_junit(found, junit)
    if json:
        print_result(found.as_dict() | {"report": str(report), "left_out": left_out}, as_json=True)
    else:
        told = [f"left out: {', '.join(left_out)}"] if left_out else []
        sys.stdout.write("\n".join([*describe(found), *told, f"report: {report}", ""]))
    _end(found, allow_weak=allow_weak)


def _chosen(
    suite: "SuiteConfig", *, on: Path | None, quick: bool, is_shipped: bool
) -> tuple["SuiteConfig", "list[list[Footage]] | None", list[str]]:
    """The suite to judge, footage of its takes where it exists, and what is left out."""
    if on is not None:
        from magicsim.evaluation.existing import existing_footage

        suite, existing = existing_footage(on, suite)
        return suite, [[film] for film in existing], []
    from magicsim.evaluation.footage import quick_suite, shipped_films

    suite, left_out = quick_suite(suite) if quick else (suite, [])
    return suite, shipped_films(suite) if is_shipped else None, left_out


def _end(found: "Evaluation", *, allow_weak: bool) -> None:
    """Ends with the exit code of a verdict; one that is good goes on."""
    if found.is_worse:
        sys.exit(REGRESSED)
    if found.cannot_judge and not allow_weak:
        sys.stderr.write(f"magicsim: cannot judge: {found.cannot_judge}; add takes, or give --allow-weak\n")
        sys.exit(UNJUDGED)


def _foretell(suite: "SuiteConfig", cache: Path) -> None:
    """Says on stderr how long the takes that are not kept will need."""
    from magicsim.evaluation.footage import foretold_s
    from magicsim.workers.attempt import usable_cores

    cores = usable_cores()
    wanted, kept, seconds = foretold_s(suite, cache, cores)
    if wanted:
        sys.stderr.write(
            f"{wanted} takes to render, about {seconds / 60:.1f} minutes on {cores} cores (rough); {kept} are kept in "
            f"{cache}\n"
        )
