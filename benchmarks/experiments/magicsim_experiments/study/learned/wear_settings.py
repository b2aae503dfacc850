"""What the file of a study of wear says."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import Field

from magicsim.config.models import Config, validate
from magicsim.dataset.recipes.draw import draw_sensors
from magicsim.dataset.recipes.recipe import Recipe, Tolerances
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.study.learned.data import LearnedConfig, Share, further_seed

Factor = Annotated[float, Field(gt=0, le=100)]
Reflectance = Annotated[float, Field(ge=0, le=1)]


class Pits(Config):
    """Scratches and pits of the face: small dots at random that scatter light."""

    per_mm2: Annotated[float, Field(gt=0, le=20)]
    """Number on a square millimetre at the end."""
    diameter_mm: Annotated[float, Field(ge=0.05, le=2)] = 0.1
    """Diameter of each [mm]."""
    color: tuple[Reflectance, Reflectance, Reflectance] = (0.5, 0.5, 0.5)
    """Diffuse reflectance in linear RGB."""


class Drift(Config):
    """One way in which a sensor ages; between new and the end of its life all of it grows in proportion."""

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]{0,39}$")]
    added: dict[str, Annotated[float, Field(ge=-1e6, le=1e6)]] = Field(default_factory=dict)
    """Change of numbers of the design at the end, by their dotted names, such as `skin_mm = -0.1`."""
    factors: dict[str, Factor] = Field(default_factory=dict)
    """Factors on numbers of the design at the end, likewise."""
    strips: tuple[Factor, ...] = ()
    """Factors on the radiance of the rig's LED strips at the end, in their order."""
    pits: Pits | None = None


def worn(
    design: ElastomerDesign, rig: Rig, drifts: Sequence[Drift], share: float, *, seed: int
) -> tuple[ElastomerDesign, Rig]:
    """A sensor some way to the end of its life.

    Args:
        share: How far, 0 is new and 1 the end.
        seed: Of the places of pits; what is worn more has those of what is worn less.

    Raises:
        ConfigError: A drift names what the design does not have, or the worn sensor is none.
    """
    data, lights = design.model_dump(), rig.model_dump()
    for drift in drifts:
        for name, change in drift.added.items():
            _change(data, drift.name, name, factor=1.0, added=share * change)
        for name, factor in drift.factors.items():
            _change(data, drift.name, name, factor=1 + share * (factor - 1), added=0.0)
        if drift.strips:
            if len(drift.strips) != len(lights["strips"]):
                msg = f"drift '{drift.name}': {len(drift.strips)} strips are not allowed: the rig has {len(rig.strips)}"
                raise ConfigError(msg)
            for strip, factor in zip(lights["strips"], drift.strips, strict=True):
                strip["radiance"] = tuple((1 + share * (factor - 1)) * each for each in strip["radiance"])
        if drift.pits is not None and share > 0:
            if data["markers"] is not None:
                msg = f"drift '{drift.name}' needs a face without markers: design.markers is set; leave the drift out"
                raise ConfigError(msg)
            data["markers"] = {
                "kind": "dots", "pattern": "random", "pitch_mm": (drift.pits.per_mm2 * share) ** -0.5,
                "diameter_mm": drift.pits.diameter_mm, "color": drift.pits.color, "seed": seed,
            }  # fmt: skip
    return validate(ElastomerDesign, data, source="the worn design"), validate(Rig, lights, source="the worn rig")


def _change(data: dict[str, Any], drift: str, name: str, *, factor: float, added: float) -> None:
    *path, last = name.split(".")
    table: Any = data
    for part in path:
        table = table.get(part) if isinstance(table, Mapping) else None
    value = table.get(last) if isinstance(table, Mapping) else None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"drift '{drift}': '{name}' is no number of the design")
    table[last] = round(factor * value + added, 12)


Some = Annotated[int, Field(ge=1, le=100_000)]


class WearConfig(LearnedConfig):
    """Settings of the study."""

    kind: Literal["wear"]
    skin_mm: Annotated[float, Field(ge=0.1, le=5)] | None = None
    """Skin of the block when new [mm]; the design's own by default."""
    drifts: Annotated[tuple[Drift, ...], Field(min_length=1, max_length=12)]
    """What wears; what is not published is assumed."""
    parts: Annotated[int, Field(ge=1, le=20)] = 10
    """Parts of the life after the training, each with the wear of its end."""
    part_episodes: Some = 24
    """Contacts of each part."""
    drift_episodes: Some = 24
    """Contacts with each drift alone at the end of a life."""
    other_episodes: Annotated[int, Field(ge=4, le=100_000)] = 160
    """Contacts of a second unit when new, of which half is kept for the test."""
    tuned_shares: tuple[Share, ...] = (0.05, 0.1, 0.15, 0.2, 0.25, 0.5, 0.75, 1.0)
    """Shares of the other half that fine-tuning takes."""
    fine_tuning: LearningSettings = LearningSettings(learning_rate=3e-4, epochs=40)
    """How the model is trained on the second unit."""

    def dataset_recipe(self, **changes: Any) -> Recipe:  # noqa: ANN401 - values of a recipe
        """The recipe on the first unit, as it was printed; see `LearnedConfig.dataset_recipe`."""
        return self.unit_recipe(0, 0, **changes)

    def unit_recipe(self, unit: int, number: int, **changes: Any) -> Recipe:  # noqa: ANN401 - values of a recipe
        """The recipe on one printed unit when new, its tolerances drawn and put in place, with contacts of its own.

        Args:
            unit: From 0.
            number: Of the dataset: 0 is the first, then parts of the life, single drifts, the second unit.
            **changes: Keys of the recipe that replace those of the file.
        """
        recipe = super().dataset_recipe(**changes)
        if self.skin_mm is not None:
            design = recipe.design.model_dump() | {"skin_mm": self.skin_mm}
            recipe = recipe.model_copy(update={"design": validate(ElastomerDesign, design, source="skin_mm")})
        printed = draw_sensors(recipe, unit + 1)[unit]
        return recipe.model_copy(update={
            "design": printed.design, "rig": printed.rig, "tolerances": Tolerances(), "rooms": (),
            "episodes_per_sensor": recipe.episodes, "seed": further_seed(self.seed, number),
        })  # fmt: skip

    def worn_recipe(self, drifts: tuple[Drift, ...], share: float, *, number: int, **changes: Any) -> Recipe:  # noqa: ANN401
        """The recipe on the first unit, worn: `share` of the way from new (0) to the end of its life (1)."""
        recipe = self.unit_recipe(0, number, **changes)
        design, rig = worn(recipe.design, recipe.rig, drifts, share, seed=self.seed)
        return recipe.model_copy(update={"design": design, "rig": rig})
