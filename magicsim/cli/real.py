"""The command that reads recorded frames: `real`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from magicsim.cli.app import Json, Seed, Settings, app, fields_of, print_result


@app.command
def real(
    description: Path, *,
    out: Annotated[Path | None, Parameter(help="Folder of the dataset; without it frames are only looked at.")] = None,
    resume: Annotated[bool, Parameter(negative="", help="Go on with what a stopped run has left there.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Make a dataset of recorded frames and their labels, or say what a description of them should set.

    The description is a TOML file that names frames (folders or videos), CSV files and their columns. The dataset has
    the columns of a simulated one: `detect`, `evaluate --on`, `calibrate`, `fit` and `estimate` read it alike.
    """
    from magicsim.cli.output.progress import show_progress
    from magicsim.dataset.real.description import load_real
    from magicsim.dataset.real.inspection import inspect_real
    from magicsim.dataset.real.writing import write_real
    from magicsim.detectors.video import quiet_opencv

    source = load_real(description, settings or [])
    with quiet_opencv():
        if out is None:
            print_result(fields_of(inspect_real(source)), as_json=json)
            return
        with show_progress(f"{description}: frames"):
            summary = write_real(source, out, resume=resume)
    print_result(fields_of(summary), as_json=json)
