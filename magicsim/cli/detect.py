"""The command that runs the detectors: `detect`."""

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from magicsim.cli.app import Json, Seed, Settings, app, refuse_settings
from magicsim.errors import ConfigError


@app.command
def detect(
    source: Path, *,
    reference: Annotated[Path | None, Parameter(help="Frames of the untouched sensor.")] = None,
    profile: str = "calibrated", frames: int | None = None, grasp: bool = False,
    seed: Seed = None, settings: Settings = None, json: Json = False,
) -> None:  # fmt: skip
    """Run the detectors on an image, a folder of images, a video, a camera (by its index), a run or a dataset.

    A run of `simulate`, a dataset and a recording with a truth.csv bring their own references.
    --frames judges so many frames at most; a camera runs until it is interrupted without it. --grasp runs the grasp
    state machine over the frames and adds its `stage` and `slip` to each.
    """
    from magicsim.detectors.offline import write_verdicts
    from magicsim.detectors.video import quiet_opencv

    refuse_settings(settings, "detect", "; write a profile file and name it with --profile")
    if reference is None:
        from magicsim.evaluation.existing import is_existing, write_existing_verdicts

        if not is_existing(source):
            msg = f"--reference is missing: '{source}' is no run, dataset or recording with untouched frames of its own"
            raise ConfigError(msg)
        write_existing_verdicts(sys.stdout, source, profile, frames=frames, grasp=grasp, as_json=json)
        return
    with quiet_opencv():  # a broken image is reported once, by us
        write_verdicts(sys.stdout, source, reference, profile, frames=frames, grasp=grasp, as_json=json)
