"""What stands in the place of a recipe where a dataset's frames were recorded: `recorded.json`."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from magicsim.config.documents import read_json
from magicsim.config.models import Config, validate
from magicsim.errors import MagicsimError, OutputError

RECORDED = "recorded.json"


class Recorded(Config):
    """Facts about frames of a real sensor; `magicsim.real` writes them."""

    schema_version: Literal[1] = 1
    rows: Annotated[int, Field(ge=1, le=65_535)]
    """Height of every frame [px]."""
    columns: Annotated[int, Field(ge=1, le=65_535)]
    """Width of every frame [px]."""
    frames_per_second: Annotated[float, Field(gt=0, le=1e6)] | None
    """Frame rate [1/s]; none where nobody said when the frames were taken."""
    table: tuple[str, ...]
    """Names of the columns, in order."""
    description: Annotated[str, Field(pattern=r"^[a-z]+\.toml$")]
    """Name of the file beside it that says where the frames came from and what was done to them."""


def read_recorded(folder: Path) -> Recorded | None:
    """The facts of a folder of recorded frames; None of simulated ones.

    Raises:
        OutputError: It is not what this version writes.
    """
    path = folder / RECORDED
    if not path.is_file():
        return None
    try:
        return validate(Recorded, read_json(path), source=RECORDED)
    except (MagicsimError, TypeError) as error:
        msg = f"'{path}' does not describe recorded frames: {error}"
        raise OutputError(msg) from None
