"""How rough the interfaces of a print are to light, finer than any mesh: half widths of the slopes of their facets."""

from typing import Annotated

from pydantic import Field

from magicsim.config.models import Config

Slope = Annotated[float, Field(ge=0, le=0.5)]


class Roughness(Config):
    """Rough interfaces, smooth by default.

    A value is the slope that half of the facets exceed (Trowbridge and Reitz's alpha). Assumed, 0.02 to 0.3: glossy
    PolyJet faces have Ra of 0.5 to 4 micrometres (Udroiu, Braga, Nedelcu, Materials 12 (2019) 995), and a wave of that
    height as long as two droplets of a 600 dpi printer (0.085 mm) has an rms slope of 0.04 to 0.33.
    """

    skin: Slope = 0.0
    """Slope of contact face and sides. The face on the lens is in optical contact and smooth."""
    walls: Slope = 0.0
    """Slope between walls and infill."""
