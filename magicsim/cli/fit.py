"""The command that fits assumed constants to a real sensor: `fit`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, Threads, app, fields_of, limit_threads, print_result
from magicsim.errors import ConfigError


@app.command
def fit(
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
    from magicsim.cli.output.progress import show_progress
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
    print_result(fields_of(result), as_json=json)


def _frame(text: str) -> tuple[int, str]:
    number, separator, source = text.partition("=")
    if not separator or not source or not number.isdecimal():
        msg = f"frame = {text} is not allowed: must be K=IMAGES, the number of a scored frame and a file or folder"
        raise ConfigError(msg)
    return int(number), source


def _blocks(text: str) -> tuple[int, int]:
    down, separator, across = text.partition("x")
    if not separator or not down.isdecimal() or not across.isdecimal():
        msg = f"blocks = {text} is not allowed: must be two whole numbers, down and across, as in 8x6"
        raise ConfigError(msg)
    return int(down), int(across)
