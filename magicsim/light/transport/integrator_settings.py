"""What the integrator has to know of a sensor, as the flat entries of a scene dictionary."""

from collections.abc import Sequence
from typing import Any

from magicsim.geometry.elastomer import Elastomer
from magicsim.light.backend import mi
from magicsim.light.transport.voxels import body_voxels
from magicsim.light.world.finish import Finish
from magicsim.light.world.medium import Medium


def read_medium(properties: Any, name: str) -> Medium:
    """Optical constants of a medium from an integrator's properties; clear where they are not given."""
    return Medium(
        sigma_s=properties.get(f"{name}_sigma_s", 0.0),
        sigma_a=properties.get(f"{name}_sigma_a", 0.0),
        anisotropy=properties.get(f"{name}_anisotropy", 0.0),
    )


def read_triple(properties: Any, name: str, kind: type = float) -> Any:
    """Three numbers, along x, y and z, from an integrator's properties."""
    return tuple(kind(properties[f"{name}_{axis}"]) for axis in "xyz")


def integrator_settings(
    elastomer: Elastomer, finish: Finish, *, inside: Sequence[str], off: Sequence[str], inset_mm: float
) -> dict[str, Any]:
    """Scene-dictionary entries of the integrator.

    Args:
        elastomer: The block at rest.
        finish: Surface of the object.
        inside: Names of the lights that shine inside the body.
        off: Names of the lights that do not shine.
        inset_mm: Depth of LED strips in optical contact inside the body [mm].
    """
    materials = elastomer.design.materials
    settings: dict[str, Any] = {
        "object_color": mi.ScalarColor3f(finish.color),
        "object_vertex_colors": finish.vertex_colors,
        "object_specular": finish.specular,
        "object_roughness": finish.roughness,
        "triangles_per_cell": max(elastomer.triangles_per_cell, 1),
        "body_ior": materials.body.ior,
        "infill_ior": materials.infill.ior if materials.infill else materials.body.ior,
        "lights_inside": ",".join(inside),
        "lights_off": ",".join(off),
        "top_mm": elastomer.design.height_mm,
        "skin_roughness": elastomer.design.roughness.skin,
        "wall_roughness": elastomer.design.roughness.walls,
    }
    for name, optics in (("body", materials.body), ("infill", materials.infill)):
        if optics is not None:
            settings |= {
                f"{name}_sigma_s": optics.sigma_s_per_mm,
                f"{name}_sigma_a": optics.absorption_per_mm,
                f"{name}_anisotropy": optics.anisotropy,
            }
    counts = elastomer.grid.counts if elastomer.grid is not None else (1, 1, 1)
    triples: dict[str, Any] = {"cells": counts}
    if materials.body.sigma_s_per_mm > 0:
        voxels = body_voxels(elastomer, inset_mm)
        triples |= {"voxels": voxels.counts, "voxel_origin": voxels.origin_mm, "voxel_size": voxels.size_mm}
    for name, values in triples.items():
        settings |= {f"{name}_{axis}": value for axis, value in zip("xyz", values, strict=True)}
    return settings
