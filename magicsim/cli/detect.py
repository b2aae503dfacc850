"""The command that runs the detectors: `detect`."""

import sys
from pathlib import Path

from magicsim.cli.app import Json, Seed, Settings, app
from magicsim.errors import ConfigError


@app.command
def detect(
    source: Path, *, reference: Path, profile: str = "calibrated", frames: int | None = None, grasp: bool = False,
    seed: Seed = None, settings: Settings = None, json: Json = False,
) -> None:  # fmt: skip
    """Run the detectors on an image, a folder of images, a video or a camera (by its index).

    --frames judges so many frames at most; a camera runs until it is interrupted without it. --grasp runs the grasp
    state machine over the frames and adds its `stage` and `slip` to each.
    """
    from magicsim.detectors.report import write_verdicts
    from magicsim.detectors.sources.video import quiet_opencv

    del seed  # nothing here is random; the option exists on every command
    if settings:
        msg = f"--set {settings[0]} is not allowed with detect; write a profile file and name it with --profile"
        raise ConfigError(msg)
    with quiet_opencv():  # a broken image is reported once, by us
        write_verdicts(sys.stdout, source, reference, profile, frames=frames, grasp=grasp, as_json=json)
