"""What is gripped: an object with its weight, friction and the force that damages it."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from magicsim.config.models import Config, load_preset
from magicsim.geometry.objects.kinds import ObjectConfig


class Item(Config):
    """An everyday thing between the fingers. It is rigid: what gives way is the skin of the sensors alone."""

    schema_version: Literal[1]
    object: ObjectConfig
    """Shape, colour and how it lies between the fingers, in the gripper's frame."""
    mass_g: Annotated[float, Field(gt=0, le=2000)]
    """Mass [g]."""
    friction: Annotated[float, Field(gt=0, le=2)]
    """Coulomb's coefficient between it and the skin of the sensors."""
    crush_n: Annotated[float, Field(gt=0, le=1000)]
    """Normal force of a finger from which it counts as crushed [N]."""


def load_item(name: str | Path) -> Item:
    """Reads an item.

    Args:
        name: Item preset, such as `orange`, or TOML file.

    Raises:
        PresetError: It does not exist.
        ConfigError: The content is not acceptable.
    """
    return load_preset(Item, "item", name)


def item_schema() -> dict[str, Any]:
    """JSON Schema of the files of items."""
    return Item.model_json_schema()
