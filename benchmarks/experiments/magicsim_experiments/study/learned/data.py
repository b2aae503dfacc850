"""Stages that every study that learns has: its data, the data that check what it rests on, and its models."""

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from magicsim.config.models import validate
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.errors import ConfigError
from magicsim.sampling.distribution import Distribution
from magicsim_experiments.learn.fitting import Fit, Read
from magicsim_experiments.learn.samples import TURNS
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.study.protocol import StudyConfig
from magicsim_experiments.study.stages import DatasetStage, LearningStage

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
            raise ConfigError(f"recipe_changes = {changes!r} is not allowed: must be a table of keys of the recipe")
        recipe = named_table(data.get("recipe"), "recipe", folder) | changes
        return data | {"recipe": {key: value for key, value in recipe.items() if key not in OF_STUDY}}

    def _problems(self) -> Iterable[str]:
        self.dataset_recipe()  # raises
        return ()

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


def further_seed(seed: int, number: int = 1) -> int:
    """Seed of a further dataset, counted from 1, for units and presses that the first ones know nothing of."""
    return (seed + number * 1_000_003) % 2**31


FRAMES = "frames"
"""Name of the stage of the data."""
QUIET, FINE, TRUE = "without-noise", "finer-rendering", "true-rendering"
"""Names of the data that check what a result rests on."""
NO_NOISE = {"full_well_e": 1e9, "read_noise_e": 0.0}
"""Camera without shot noise and read noise: a well of 1e9 electrons has a relative shot noise of 3e-5."""
FINER = 4
"""Factor on samples and particles of the finer rendering, with another seed of its noise."""


def data_stages(config: LearnedConfig, *, masks: bool = False) -> list[DatasetStage]:
    """The data, and the first episodes again without noise and with finer rendering; truly rendered if they were fast.

    Args:
        masks: Whether contact masks are needed; all other large labels are left out.
    """
    large = {"contact_mask": masks, "depth_map": False, "displacements": False}
    recipe = config.dataset_recipe(labels=large)
    stages = [DatasetStage(name=FRAMES, recipe=recipe)]
    if config.check_episodes:
        count = min(config.check_episodes, recipe.episodes)
        render = recipe.render
        again, other = TRUE, render.model_dump() | {"tier": "true"}
        if render.tier == "true":
            again, other = FINE, other | {
                "samples": FINER * render.samples, "particles": FINER * render.particles,
                "anchor_samples": 2 * render.anchor_samples, "anchor_seed": render.anchor_seed + 1,
            }  # fmt: skip
        quiet = recipe.camera.model_dump(exclude_none=True)
        for name, value in NO_NOISE.items():
            drawn = isinstance(getattr(recipe.camera, name), Distribution)
            quiet[name] = {"low": value, "high": value} if drawn else value  # drawn still, so that others stay
        stages += [
            DatasetStage(name=QUIET, recipe=config.dataset_recipe(labels=large, episodes=count, camera=quiet)),
            DatasetStage(name=again, recipe=config.dataset_recipe(labels=large, episodes=count, render=other)),
        ]
    return stages


def planned_fits(settings: LearningSettings, *, units: int, objects: int = 0) -> tuple[Fit, ...]:
    """The models: folds by press, by unit and by object, shares of the data, other networks on a fold.

    Args:
        objects: Number of objects in the data; 0 where they are not told apart.
    """
    first, *others = settings.networks
    used = min(settings.folds, settings.folds_used)

    def fits(name: str, share: float = 1.0) -> list[Fit]:
        return [Fit(name=f"{name}-{k}", network=first, fold=k, folds=settings.folds, share=share) for k in range(used)]

    found = fits("press")
    for share in sorted(settings.curve):
        found += fits(share_name(share), share=share)
    found += [Fit(name=f"{other}-0", network=other, fold=0, folds=settings.folds) for other in others]
    groups: tuple[tuple[Literal["unit", "object"], int], ...] = (("unit", units), ("object", objects))
    for split_by, count in groups:
        folds = min(settings.folds, count)
        if folds > 1:
            found += [
                Fit(name=f"{split_by}-{k}", network=first, split_by=split_by, fold=k, folds=folds)
                for k in range(min(folds, used))
            ]
    return tuple(found)


def share_name(share: float) -> str:
    """How fits with a share of the training presses are called."""
    return f"share-{round(1000 * share):03d}"


def learning_stage(
    config: LearnedConfig, stages: Sequence[DatasetStage], read: Read, *, frames_per_episode: int,
    name: str = "learning", objects: int = 0,
) -> LearningStage:  # fmt: skip
    """The models of a study on its first dataset, which answer on the others too.

    Args:
        frames_per_episode: How many of an episode's frames count, about.
        objects: Number of objects that are kept apart, see `count_objects`; 0 for none.
    """
    recipe = stages[0].recipe
    units = -(-recipe.episodes // recipe.episodes_per_sensor)
    return LearningStage(
        name=name, fits=planned_fits(config.learning, units=units, objects=objects), dataset=stages[0].name,
        recipe=recipe, read=read, settings=config.learning, frames=recipe.episodes * frames_per_episode,
        study=config.kind, seed=config.seed, also={stage.name: True for stage in stages[1:]},
    )  # fmt: skip


def count_objects(recipe: Recipe) -> int:
    """Different objects of a recipe, whatever their orientation; 0 where sizes or colours are drawn from ranges."""
    total = 0
    for each in recipe.objects:
        drawn = [
            number for name, number in each.numbers().items()
            if isinstance(number, Distribution) and name not in TURNS
        ]  # fmt: skip
        if each.kind == "mesh" or any(not number.choices for number in drawn):
            return 0
        total += math.prod(len(number.choices or ()) for number in drawn)
    return total


def refuse_few(config: LearnedConfig) -> None:
    """Refuses data that cannot be learned from.

    Raises:
        ConfigError: There are fewer episodes than folds, or no references.
    """
    recipe, folds = config.dataset_recipe(), config.learning.folds
    if recipe.episodes < 2 * folds:
        raise ConfigError(
            f"recipe.episodes = {recipe.episodes} is not allowed with learning.folds = {folds}: "
            f"must be at least {2 * folds}"
        )
    if recipe.references < 1:
        raise ConfigError("recipe.references = 0 is not allowed: a model reads frames beside an untouched one")
