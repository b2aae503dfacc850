"""Any watertight triangle mesh as an object; its file is read only when the shape is asked for."""

from dataclasses import replace
from typing import Annotated, Literal

from pydantic import Field

from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.objects.rigid_object import ObjectBase, Size
from magicsim.geometry.shapes.solids import Shape


class MeshObject(ObjectBase):
    """A watertight mesh from an STL, OBJ, PLY or GLB file, in the file's own frame."""

    kind: Literal["mesh"]
    path: str
    """The file; a relative path starts beside the TOML file that it stands in, or in the current folder."""
    scale: Annotated[float, Field(ge=1e-6, le=1e6)] = 1.0
    """Millimetres per unit of the file."""
    file_colors: bool = False
    """Whether the file's texture, vertices or faces (OBJ, PLY, GLB) give the colour instead of `color`; it is taken at
    the vertices of the drawn triangles."""
    feature_mm: Size | None = None
    """Smallest detail that contact resolves [mm]; half of the mesh's smallest extent by default."""

    def surface(self) -> SurfaceMesh:
        """See `ObjectBase.surface`, with the colours of the file where they are asked for.

        Raises:
            ConfigError: The file does not exist, cannot press, or holds no colours.
        """
        surface = self.shape().mesh()
        if not self.file_colors:
            return surface
        from magicsim.geometry.files.mesh_colors import file_colors

        return replace(surface, colors=file_colors(self.path, surface.vertices / self.scale))

    def shape(self) -> Shape:
        """The solid, read from its file.

        Raises:
            ConfigError: The file does not exist or does not hold a mesh that can press.
        """
        from magicsim.geometry.files.mesh_file import load_mesh

        return self.entered_from_above(load_mesh(self.path, scale=self.scale, feature_mm=self.feature_mm))
