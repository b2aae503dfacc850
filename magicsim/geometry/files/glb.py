"""GLB files for viewers: glTF 2.0 is in metres with y up, so the parts' nodes carry scale and rotation."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import trimesh
from trimesh.visual.material import PBRMaterial
from trimesh.visual.texture import TextureVisuals

from magicsim.geometry.files.part import Part

METRES_PER_MM = 1e-3
TO_VIEWER = np.array(
    [
        [METRES_PER_MM, 0, 0, 0],
        [0, 0, METRES_PER_MM, 0],
        [0, -METRES_PER_MM, 0, 0],
        [0, 0, 0, 1],
    ]
)
"""From the sensor's frame [mm] to glTF's [m]: the contact face looks down, the sensor's z axis points up (y)."""


def write_glb(path: Path, parts: Sequence[Part]) -> None:
    """Writes the parts as named nodes; the stored vertices are in mm, the nodes' matrices make them metres.

    Raises:
        OSError: The file cannot be written.
    """
    scene = trimesh.Scene()
    for part in parts:
        mesh = trimesh.Trimesh(part.mesh.vertices, part.mesh.faces, process=False)
        mesh.visual = TextureVisuals(material=_material(part))  # type: ignore[no-untyped-call]
        scene.add_geometry(mesh, node_name=part.name, geom_name=part.name, transform=TO_VIEWER)
    # Without normals viewers shade each triangle flat, as the glTF specification (section 3.7.2.1) asks
    path.write_bytes(scene.export(file_type="glb", include_normals=False))  # type: ignore[no-untyped-call]


def _material(part: Part) -> PBRMaterial:
    return PBRMaterial(  # type: ignore[no-untyped-call]
        name=part.name,
        baseColorFactor=part.colour,
        metallicFactor=0.0,
        roughnessFactor=0.2,
        alphaMode="BLEND",
        doubleSided=False,
    )
