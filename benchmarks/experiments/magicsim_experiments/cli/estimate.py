"""The command that reads frames with a learned model: `estimate`."""

import json as text
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from magicsim.cli.app import Json, Seed, Settings, refuse_settings


def estimate(
    model: Path, source: Path, *,
    reference: Annotated[Path | None, Parameter(help="Frames of the untouched sensor.")] = None,
    frames: Annotated[int | None, Parameter(help="Most frames to read.")] = None,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Read frames with a model that a study has learned: one line of JSON, or of text, a frame.

    The source is an image, a folder of images, a video, a camera (by its index), or a finished dataset, which brings
    its own references.
    """
    from magicsim.cli.lines import lines_of
    from magicsim_experiments.learn.settings import need_torch

    refuse_settings(settings, "estimate")
    need_torch("estimate")
    from magicsim_experiments.learn.reading import estimate_frames
    from magicsim_experiments.learn.samples import FRAME

    for each in estimate_frames(model, source, reference=reference, frames=frames):
        values = {FRAME: each.frame, **each.values}
        line = text.dumps(values, allow_nan=False) if json else "; ".join(lines_of(values))
        sys.stdout.write(line + "\n")
