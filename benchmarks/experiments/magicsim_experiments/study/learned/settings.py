"""What the file of a study that learns says: the recipe of its data, its fit to a design, how it is learned."""

from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from magicsim.config.models import validate
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.errors import ConfigError
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.study.protocol import StudyConfig

OF_STUDY = ("schema_version", "design", "rig", "seed", "splits", "split_by")
"""Keys of a recipe that the study gives."""
Share = Annotated[float, Field(gt=0, le=1)]


class LearnedConfig(StudyConfig):
    """Settings of a study that learns."""

    recipe: dict[str, Any]
    """What the data are drawn from, a table as in `scenes/recipes/*.toml` without design, rig and seed; a file may give
    the name of a recipe preset instead."""
    place_share: Share = 0.55
    """Places are drawn from this share of the face, around its middle."""
    depth_share: Share = 0.4
    """Deepest press in units of the block's height, where the recipe presses deeper."""
    camera_scale: Share = 1.0
    """Size of the rendered frames in units of the rig's."""
    check_episodes: Annotated[int, Field(ge=0, le=100_000)] = 12
    """Episodes that are rendered again without noise of the camera, and again with four times the samples, to see what
    the result rests on; 0 leaves that out."""
    learning: LearningSettings = LearningSettings()

    @classmethod
    def completed(cls, data: dict[str, Any], *, folder: Path, quick: bool) -> dict[str, Any]:
        """The file's content with the recipe in place."""
        from magicsim_experiments.study.study_file import named_table

        changes = data.pop("recipe_changes", {})
        if not isinstance(changes, dict):
            msg = f"recipe_changes = {changes!r} is not allowed: must be a table of keys of the recipe"
            raise ConfigError(msg)
        recipe = named_table(data.get("recipe"), "recipe", folder) | changes
        return data | {"recipe": {key: value for key, value in recipe.items() if key not in OF_STUDY}}

    @model_validator(mode="after")
    def _check_recipe(self) -> Self:
        self.dataset_recipe()
        return self

    def dataset_recipe(self, **changes: Any) -> Recipe:  # noqa: ANN401 - values of a recipe
        """The recipe with the study's design, rig and seed in place, its places and depths fitted to the block.

        Args:
            **changes: Keys of the recipe that replace those of the file.
        """
        camera = self.rig.camera
        size = {"columns": round(camera.columns * self.camera_scale), "rows": round(camera.rows * self.camera_scale)}
        rig = self.rig.model_dump()
        rig["camera"] |= size
        data = {key: value for key, value in self.recipe.items() if key not in OF_STUDY} | changes
        data |= {"schema_version": 1, "design": self.design.model_dump(), "rig": rig, "seed": self.seed}
        data |= {"splits": {"train": 1.0, "validation": 0.0, "test": 0.0}}
        data["paths"] = [self._fitted(path) for path in data.get("paths", [])]
        return validate(Recipe, data, source="recipe")

    def _fitted(self, path: dict[str, Any]) -> dict[str, Any]:
        """A path with drawn places within the face and depths within the block."""
        found = dict(path)
        for name, size in zip(("x_mm", "y_mm"), self.design.footprint_mm, strict=True):
            if isinstance(found.get(name), dict):
                half = round(self.place_share * size / 2, 6)
                found[name] = {"low": -half, "high": half}
        deepest, depth = round(self.depth_share * self.design.height_mm, 6), found.get("depth_mm")
        if isinstance(depth, dict) and depth.get("high", 0.0) > deepest:
            found["depth_mm"] = depth | {"high": deepest, "low": min(depth.get("low", 0.0), deepest)}
        return found
