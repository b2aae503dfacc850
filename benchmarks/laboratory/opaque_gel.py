"""An opaque gel for comparison: the default sensor's press, lights and camera, on a membrane that is painted.

A scene of our own of the kind that simulators of such sensors path trace (Agarwal et al. 2021): only the membrane is
seen, diffuse, lit directly and by its neighbourhood.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.camera.film import film
from magicsim.light.backend import mi
from magicsim.simulation.sensor import Sensor

SAMPLES = 64
DEPTH = 6
"""Longest path [interactions]: the membrane lights itself a few times."""
REFLECTANCE = 0.6
"""Of the paint, assumed."""


def membrane(sensor: Sensor, body: npt.NDArray[np.float64]) -> Any:  # noqa: ANN401
    """The contact face of a body as a painted membrane."""
    face = sensor.elastomer.body
    below = face.vertices[:, 2] < 1e-9
    faces = face.faces[below[face.faces].all(1)]
    properties = mi.Properties()
    paint = {"type": "diffuse", "reflectance": {"type": "rgb", "value": REFLECTANCE}}
    properties["bsdf"] = mi.load_dict({"type": "twosided", "bsdf": paint})
    mesh = mi.Mesh("membrane", len(body), len(faces), props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = np.ascontiguousarray(body, np.float32).ravel()
    parameters["faces"] = np.ascontiguousarray(faces, np.uint32).ravel()
    parameters.update()
    return mesh


def opaque_scene(sensor: Sensor, body: npt.NDArray[np.float64]) -> Any:  # noqa: ANN401
    """Membrane, three-coloured strips beside it, and the sensor's camera without refraction."""
    scene, design = sensor, sensor.design
    ideal = film(design, scene.rig.lens, scene.rig.camera)
    width, length = design.footprint_mm
    described: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": DEPTH},
        "membrane": membrane(sensor, body),
        "sensor": {
            "type": "perspective",
            "fov": ideal.fov_deg,
            "fov_axis": "x",
            "to_world": mi.ScalarTransform4f().look_at(
                origin=[0, 0, design.height_mm + scene.rig.camera.distance_mm], target=[0, 0, 0], up=[0, 1, 0]
            ),
            "film": {
                "type": "hdrfilm", "width": ideal.columns, "height": ideal.rows, "pixel_format": "rgb",
                "component_format": "float32", "rfilter": {"type": "box"},
            },
        },
    }  # fmt: skip
    for number, strip in enumerate(scene.rig.strips):
        along = length / 2 if strip.side[1] == "x" else width / 2
        out = np.array([1.0, 0, 0] if strip.side[1] == "x" else [0, 1.0, 0]) * (1 if strip.side[0] == "+" else -1)
        place = out * (width if strip.side[1] == "x" else length) / 2 + [0, 0, design.height_mm / 2]
        turned = mi.ScalarTransform4f().look_at(origin=place.tolist(), target=[0, 0, place[2]], up=[0, 0, 1])
        described[f"strip{number}"] = {
            "type": "rectangle",
            "to_world": turned @ mi.ScalarTransform4f().scale([along, design.height_mm / 4, 1]),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": list(strip.radiance)}},
        }
    # The merge step would order shapes by chance, and with them the random numbers of their light.
    return mi.load_dict(described, optimize=False)
