"""Which fields of touch an episode or a dataset holds: `[output.taxels]` of scenes, `[labels.taxels]` of recipes."""

from typing import Annotated, Literal

from pydantic import Field

from magicsim.config.models import Config
from magicsim.geometry.design import ElastomerDesign

Count = Annotated[int, Field(ge=1, le=256)]


class TaxelSettings(Config):
    """A grid of taxels over the contact face, and what is known of each; row 0 is at +y, column 0 at -x."""

    rows: Count = 16
    """Taxels along y."""
    columns: Count = 12
    """Taxels along x."""
    unit: Literal["N", "MPa"] = "N"
    """Force of each taxel (`taxel_force_n`), or force per undeformed area (`taxel_traction_mpa`)."""
    skin: bool = True
    """Largest stretch and von Mises stress of the skin, on the whole and below each taxel."""
    infill: bool = True
    """Shear of the infill, on the whole and below each taxel; designs without infill have none."""

    def has_infill(self, design: ElastomerDesign) -> bool:
        """Whether the shear of the infill is among the fields of a design."""
        return self.infill and design.has_grid and design.materials.infill is not None
