"""The commands that fit numbers to frames: `fit optics` those of the light, `fit profile` those of the detectors."""

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, Threads, app, fields_of, limit_threads, print_result
from magicsim.errors import ConfigError

fit_app = App(name="fit", help="Fit a detector profile to labelled frames, or optical constants to a real sensor.")
app.command(fit_app)


@fit_app.command
def optics(
    references: Path, *, out: Out, scene: str = "rest",
    frame: Annotated[
        list[str] | None,
        Parameter(negative="", help="K=IMAGES: images that show the scene's scored frame K; repeatable."),
    ] = None,
    free: Annotated[
        list[str] | None, Parameter(negative="", help="A constant to fit; repeatable. Some by default.")
    ] = None,
    blocks: Annotated[str, Parameter(help="Blocks down and across, as in 8x6.")] = "8x6",
    starts: int = 2, evaluations: int = 12,
    settings: Settings = None, seed: Seed = None, threads: Threads = None, json: Json = False,
) -> None:  # fmt: skip
    """Fit assumed optical constants to images of a real sensor, untouched and, with --frame, in states of a scene.

    Writes the fitted sensor as a scene file and a picture of the residual beside it. The strengths of all lights are
    fitted too. --starts is the number of searches, from the scene's own constants and from other places; --evaluations
    bounds the points that each one tries beside those of its derivatives.
    """
    from magicsim.cli.progress import show_progress
    from magicsim.detectors.video import quiet_opencv
    from magicsim.fit.fitting import DEFAULT_FREE, fit_constants
    from magicsim.fit.observation import read_observation
    from magicsim.scenes.scene import load_scene

    config = load_scene(scene, settings or [], seed=seed)
    limit_threads(threads)
    shown: list[tuple[int | None, str]] = [(None, str(references)), *(_frame(each) for each in frame or [])]
    with quiet_opencv():
        observations = [read_observation(source, config.rig.camera, frame=number) for number, source in shown]
    with show_progress(f"{scene}: fit"):
        result = fit_constants(
            config, observations, out, free=free or DEFAULT_FREE, blocks=_blocks(blocks), starts=starts,
            evaluations=evaluations, seed=config.seed,
        )  # fmt: skip
    print_result(result, as_json=json)


@fit_app.command
def profile(
    *episodes: Path, out: Out, base: str = "published", settings: Settings = None, seed: Seed = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Fit a detector profile to labelled episodes of one sensor: runs, datasets, images with a labels.csv.

    --base names the profile that gives what is not fitted. --set narrows the search, as in `--set tau_b=[35,50]` or
    `--set polarity=dark`, or changes another option of the base.
    """
    from magicsim.detectors.video import quiet_opencv
    from magicsim.evaluation.existing import labelled_episodes
    from magicsim.judge.profile_fit import calibrate

    if not episodes:
        raise ConfigError("episodes are missing; give at least one folder of a labelled episode")
    with quiet_opencv():
        summary = fields_of(calibrate(episodes, out, base=base, settings=settings or [], read=labelled_episodes))
    if not json:
        for separation in summary["roc"].values():
            del separation["curve"]
    print_result(summary, as_json=json)


def _frame(text: str) -> tuple[int, str]:
    number, separator, source = text.partition("=")
    if not separator or not source or not number.isdecimal():
        msg = f"frame = {text} is not allowed: must be K=IMAGES, the number of a scored frame and a file or folder"
        raise ConfigError(msg)
    return int(number), source


def _blocks(text: str) -> tuple[int, int]:
    down, separator, across = text.partition("x")
    if not separator or not down.isdecimal() or not across.isdecimal():
        raise ConfigError(f"blocks = {text} is not allowed: must be two whole numbers, down and across, as in 8x6")
    return int(down), int(across)
