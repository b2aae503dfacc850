"""Which rooms a recipe's sensors stand in."""

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from magicsim.config.models import Config
from magicsim.dataset.recipes.object_recipe import Draw, Weight
from magicsim.sampling.distribution import Number
from magicsim.scenes.rig import DARK


class RoomRecipe(Config):
    """A room, and how bright it is against the LED strips."""

    room: Annotated[str, Field(max_length=1000)] | None = None
    """As `rig.room`: a preset, `dark`, or an image; even light by default."""
    ambient: Number = 0.1
    """Mean radiance of all channels, in the units of the strips' radiance; of no meaning in the dark."""
    weight: Weight = 1.0
    """How often this entry is chosen, relative to the others."""

    @model_validator(mode="after")
    def _check_room(self) -> Self:
        if self.room is not None and self.room != DARK:
            from magicsim.scenes.room import room_file

            room_file(self.room)
        return self

    def numbers(self) -> dict[str, Number]:
        """What may be drawn, by name."""
        return {"ambient": self.ambient}

    def placed(self, rig: dict[str, Any], draw: Draw) -> dict[str, Any]:
        """A rig's settings in this room."""
        return rig | {"room": self.room, "ambient": (draw("ambient", self.ambient),) * 3}
