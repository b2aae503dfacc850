"""Colour, gloss and orientation of a rigid object, and the checks that several kinds share."""

from typing import Annotated

import numpy as np
from pydantic import Field

from magicsim.config.models import Config
from magicsim.geometry.coat import Color, Share
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.pose import Pose
from magicsim.geometry.shapes.entry import EntrySide
from magicsim.geometry.shapes.solids import Shape

Size = Annotated[float, Field(gt=0.01, le=200)]
MOST_TWIST_DEG = 3600.0
"""Ten turns: a path may turn an object more than once [degrees]."""
AngleDeg = Annotated[float, Field(ge=-MOST_TWIST_DEG, le=MOST_TWIST_DEG)]
EDGE_RADIUS_MM = 0.1
SHELL_MM = 0.05
"""Depth below a surface up to which contact keeps the nearest feature, see `EntrySide` [mm]."""
SHELL_SHARE = 0.25
"""Depth of the shell in units of the radius or half width of a slender part; the smaller one holds."""
REACH_MM = 0.5
"""Way to the surface above up to which contact holds to the side of entry, see `EntrySide` [mm]: a long load step."""
REACH_FEATURES = 2.0
"""Reach in units of the solid's smallest feature; the smaller one holds. A load step is at most half a feature."""


class ObjectBase(Config):
    """Fields that every object has beside its shape."""

    color: Color = (0.7, 0.7, 0.7)
    """Diffuse reflectance in linear RGB, 0..1."""
    specular: Share = 0.0
    """Share of the light that the surface mirrors, like bare metal or varnish; the rest meets the diffuse ground."""
    roughness: Annotated[float, Field(ge=0.02, le=1)] = 0.2
    """Root mean square slope of the facets that mirror."""
    roll_deg: AngleDeg = 0.0
    """Rotation about x, applied first [degrees]."""
    pitch_deg: AngleDeg = 0.0
    """Rotation about y, applied second [degrees]."""
    yaw_deg: AngleDeg = 0.0
    """Rotation about z, applied last and added to the path's twist [degrees]."""

    def shape(self) -> Shape:
        """The solid about the object's origin, with contact by the side of entry."""
        return self.entered_from_above(self._solid())

    def _solid(self) -> Shape:
        """The exact solid; every kind has its own, or a `shape`."""
        raise NotImplementedError

    def surface(self) -> SurfaceMesh:
        """Triangles of the solid, as the renderer draws them."""
        return self.shape().mesh()

    def refuse_contact(self) -> None:
        """Raises ConfigError where the object may be seen and not touch; none by default."""

    def entered_from_above(
        self, solid: Shape, *, shell_mm: float | None = None, reach_mm: float | None = None, pose: Pose | None = None
    ) -> Shape:
        """The solid with contact by the side of entry, approached along the sensor's +z in this orientation or a pose.

        Shell and reach are those of `EntrySide`, by default 0.05 mm or a quarter of a feature, and 0.5 mm or two
        features.
        """
        pose = pose or Pose.from_degrees(np.zeros(3), roll=self.roll_deg, pitch=self.pitch_deg)
        x, y, z = pose.rotation[2].tolist()
        shell = shell_mm if shell_mm is not None else min(SHELL_MM, SHELL_SHARE * solid.feature_mm)
        reach = reach_mm if reach_mm is not None else min(REACH_MM, REACH_FEATURES * solid.feature_mm)
        return EntrySide(solid, (x, y, z), shell, reach)


def edge_problem(edge_radius_mm: float, *half_sizes_mm: float) -> str | None:
    """What is wrong with an edge radius that is not below all half sizes and leaves nothing between the edges."""
    if edge_radius_mm < min(half_sizes_mm):
        return None
    return f"edge_radius_mm = {edge_radius_mm:g} is not allowed: must be below {min(half_sizes_mm):g} mm"
