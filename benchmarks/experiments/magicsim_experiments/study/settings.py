"""What every study's file says, whatever its kind: the base of the configuration models of `scenes/studies/*.toml`."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from magicsim.config.models import Config
from magicsim.config.named_files import config_digest
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import Seed


class StudyConfig(Config):
    """Settings of a study."""

    schema_version: Literal[1]
    kind: str
    """What is studied, a key of `magicsim_experiments.study.kinds.KINDS`."""
    design: ElastomerDesign
    """The block; a file or `--design` may give the name of a design preset instead."""
    rig: Rig
    """What surrounds it; a file may give the name of a rig preset instead. Left out, it is the rig of the scene that
    has the design's name, or `digit-office`."""
    seed: Seed = 0
    """Seed of everything random."""
    timeout_s: Annotated[float, Field(ge=0.001, le=1e6)] = 1800.0
    """Longest time for one attempt at a part of the work [s]."""

    @classmethod
    def of_another_design(cls, data: dict[str, Any]) -> dict[str, Any]:
        """Content of a file whose own design, a table, has been replaced by one that was named."""
        return data

    @classmethod
    def completed(cls, data: dict[str, Any], *, folder: Path, quick: bool) -> dict[str, Any]:
        """The file's content with what this kind of study names, such as a recipe, put in place.

        Args:
            data: Content; design and rig may still be names.
            folder: Where the file stands.
            quick: Whether the small form was asked for.
        """
        return data

    def config_hash(self) -> str:
        """SHA-256 of everything that the result depends on, the content of files that are named included."""
        data = self.model_dump(mode="json", exclude={"timeout_s"})
        return config_digest(data)
