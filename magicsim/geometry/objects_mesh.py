"""Any watertight triangle mesh as an object; its file is read only when the shape is asked for."""

from typing import Annotated, Literal

from pydantic import Field

from magicsim.geometry.objects_base import SHELL_MM, SHELL_SHARE, ObjectBase, Size
from magicsim.geometry.shapes import Shape


class MeshObject(ObjectBase):
    """A watertight mesh from an STL, OBJ, PLY or GLB file, in the file's own frame."""

    kind: Literal["mesh"]
    path: str
    """The file, relative to the current directory."""
    scale: Annotated[float, Field(ge=1e-6, le=1e6)] = 1.0
    """Millimetres per unit of the file."""
    feature_mm: Size | None = None
    """Smallest detail that contact resolves [mm]; half of the mesh's smallest extent by default."""

    def shape(self) -> Shape:
        """The solid, read from its file.

        Raises:
            ConfigError: The file does not exist or does not hold a mesh that can press.
        """
        from magicsim.geometry.mesh_file import load_mesh

        solid = load_mesh(self.path, scale=self.scale, feature_mm=self.feature_mm)
        return self.entered_from_above(solid, shell_mm=min(SHELL_MM, SHELL_SHARE * solid.feature_mm))
