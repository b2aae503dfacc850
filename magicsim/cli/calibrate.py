"""The command that fits a detector profile: `calibrate`."""

from pathlib import Path

from magicsim.cli.app import Json, Out, Seed, Settings, app, fields_of, print_result


@app.command
def calibrate(
    *episodes: Path, out: Out, base: str = "published", settings: Settings = None, seed: Seed = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Fit a detector profile to labelled episodes of one sensor: runs, datasets, images with a labels.csv.

    --base names the profile that gives what is not fitted. --set narrows the search, as in `--set tau_b=[35,50]` or
    `--set polarity=dark`, or changes another option of the base.
    """
    from magicsim.detectors.video import quiet_opencv
    from magicsim.errors import ConfigError
    from magicsim.evaluation.existing import labelled_episodes
    from magicsim.judge.profile_fit import calibrate as fit

    if not episodes:
        msg = "episodes are missing; give at least one folder of a labelled episode"
        raise ConfigError(msg)
    with quiet_opencv():
        summary = fields_of(fit(episodes, out, base=base, settings=settings or [], read=labelled_episodes))
    if not json:
        for separation in summary["roc"].values():
            del separation["curve"]
    print_result(summary, as_json=json)
