"""Any watertight triangle mesh as an object; its file is read only when the shape is asked for."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from magicsim.config.named_files import FileName
from magicsim.errors import ConfigError
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.objects.rigid_object import ObjectBase, Size

if TYPE_CHECKING:
    from magicsim.geometry.shapes.mesh_solid import MeshShape

LEAST_TOUCHING_MM = 0.5
"""Across which a mesh of unknown unit has to be to touch [mm]."""


class MeshObject(ObjectBase):
    """A watertight mesh from an STL, OBJ, PLY, OFF or GLB file, in the file's frame; that of a GLB file has y up."""

    kind: Literal["mesh"]
    path: FileName
    """The file; a relative path starts beside the TOML file that it stands in, or in the current folder."""
    scale: Annotated[float, Field(ge=1e-6, le=1e6)] | None = None
    """Millimetres per unit of the file; by default 1, and of a GLB file, which is in metres, 1000."""
    file_colors: bool = False
    """Whether the file's texture, vertices or faces (OBJ, PLY, GLB) give the colour instead of `color`; it is taken at
    the vertices of the drawn triangles."""
    feature_mm: Size | None = None
    """Smallest detail that contact resolves [mm]; half of the mesh's smallest extent by default."""

    def surface(self) -> SurfaceMesh:
        """See `ObjectBase.surface`, with the file's colours where asked for; `ConfigError` where it cannot press."""
        surface = self.shape().mesh()
        if not self.file_colors:
            return surface
        from magicsim.geometry.files.mesh_colors import file_colors
        from magicsim.geometry.files.mesh_file import mm_per_unit

        points = surface.vertices / mm_per_unit(self.path, self.scale)
        return replace(surface, colors=file_colors(self.path, points))

    def _solid(self) -> "MeshShape":
        from magicsim.geometry.files.mesh_file import load_mesh

        return load_mesh(self.path, scale=self.scale, feature_mm=self.feature_mm)

    def refuse_contact(self) -> None:
        """See `ObjectBase.refuse_contact`: a mesh that is tiny although nobody gave its scale is in metres."""
        if self.scale is None:
            low, high = self._solid().box_mm
            if (across := float((high - low).max())) < LEAST_TOUCHING_MM:
                raise ConfigError(
                    f"mesh '{self.path}' is {across:.4g} mm across and cannot touch: at least {LEAST_TOUCHING_MM:g} mm "
                    "are needed where no scale is given; metres? try scale=1000"
                )
