"""What wears in a sensor, as named drifts of its design and its lights, each with a size at the end of a life."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import Field

from magicsim.config.models import Config, validate
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.rig import Rig

Factor = Annotated[float, Field(gt=0, le=100)]
Share = Annotated[float, Field(ge=0, le=1)]


class Pits(Config):
    """Scratches and pits of the face: small dots at random that scatter light."""

    per_mm2: Annotated[float, Field(gt=0, le=20)]
    """Number on a square millimetre at the end."""
    diameter_mm: Annotated[float, Field(ge=0.05, le=2)] = 0.1
    """Diameter of each [mm]."""
    color: tuple[Share, Share, Share] = (0.5, 0.5, 0.5)
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
        design: When new.
        rig: When new.
        drifts: What wears.
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
        msg = f"drift '{drift}': '{name}' is no number of the design"
        raise ConfigError(msg)
    table[last] = round(factor * value + added, 12)
