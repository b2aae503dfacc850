"""The fluence estimator as a Mitsuba integrator, so that `mi.render(scene)` is all that a user needs."""

from typing import Any

import mitsuba as mi
import numpy as np
import numpy.typing as npt

from magicsim.geometry.elastomer import Elastomer
from magicsim.scenes.camera_pass import gather_radiance
from magicsim.scenes.light_pass import FIXED_POINT, cell_volumes_mm3, deposit_tracks
from magicsim.scenes.medium import Media

FloatArray = npt.NDArray[np.float64]
LIGHT_DEPTH = 400
CAMERA_DEPTH = 200
CHUNK = 500_000
"""Particles traced at once: bounds the memory, does not change the result."""
BODY, INFILL, OBJECT, FLASHLIGHT = "body", "infill", "object", "flashlight"
"""Identifiers of shapes in the Mitsuba scene."""
SEEDS_PER_RENDER = 64
"""Random streams that one seed owns: the camera's, and one a light."""


class FluenceIntegrator(mi.CppADIntegrator):  # type: ignore[misc]
    """Cached-fluence rendering of a scattering grid in a clear body.

    Unbiased for isotropic scattering in the limit of small cells and many particles. Scene requirements: a shape
    `body`, and a shape `infill` of disjoint cells with `triangles_per_cell` triangles each, cell-major.
    """

    def __init__(self, properties: Any) -> None:
        """Reads `particles`, `triangles_per_cell` and the media's constants."""
        super().__init__(properties)
        self.particles = properties.get("particles", 200_000)
        self.triangles_per_cell = properties.get("triangles_per_cell", 12)
        self.media = Media(
            body_ior=properties["body_ior"],
            infill_ior=properties["infill_ior"],
            body_absorption=properties["body_absorption"],
            sigma_s=properties["sigma_s"],
            sigma_a=properties["sigma_a"],
        )

    def render(
        self, scene: Any, sensor: Any = 0, seed: int = 0, spp: int = 0, develop: bool = True, evaluate: bool = True
    ) -> Any:
        """Renders the scene's first sensor; returns a tensor of shape (rows, columns, 3)."""
        fluence = sum(self.light(scene, light, particles=self.share(scene), seed=seed) for light in lights(scene))
        return self.gather(scene, fluence, samples=spp or 16, seed=seed)

    def share(self, scene: Any) -> int:
        """Particles of each light: all strips together get `particles`, an outside light gets as many again."""
        strips = sum(name != FLASHLIGHT for name in lights(scene))
        return max(1, self.particles // max(1, strips))

    def light(self, scene: Any, name: str, *, particles: int, seed: int) -> FloatArray:
        """Fluence that one light makes in every cell.

        Args:
            scene: The loaded scene.
            name: Identifier of the emitting shape, one of `lights(scene)`.
            particles: Number of particles.
            seed: Seed of the render; every light has a stream of its own.

        Returns:
            Fluence per cell and channel, shape (cells, 3).
        """
        body, infill = _shape(scene, BODY), _shape(scene, INFILL)
        if infill is None or self.media.sigma_s == 0:
            return np.zeros((1, 3))
        parameters = mi.traverse(infill)
        vertices = np.array(parameters["vertex_positions"], np.float64).reshape(-1, 3)
        faces = np.array(parameters["faces"]).reshape(-1, 3)
        volumes = cell_volumes_mm3(vertices, faces, len(faces) // self.triangles_per_cell)
        emitter = _shape(scene, name).emitter()
        stream = SEEDS_PER_RENDER * seed + 1 + lights(scene).index(name)
        deposits = np.zeros(3 * len(volumes))
        for chunk, size in enumerate(_chunks(particles)):
            deposits += deposit_tracks(
                scene, emitter, body, infill, self.media, triangles_per_cell=self.triangles_per_cell,
                cells=len(volumes), first=chunk * CHUNK, particles=size, seed=stream, max_depth=LIGHT_DEPTH,
            )  # fmt: skip
        flux = deposits.reshape(-1, 3) / (FIXED_POINT * particles)
        return flux / volumes[:, None]

    def gather(self, scene: Any, fluence: FloatArray, *, samples: int, seed: int) -> Any:
        """Radiance image from a fluence of shape (cells, 3), a tensor of shape (rows, columns, 3)."""
        image = gather_radiance(
            scene, _shape(scene, BODY), _shape(scene, INFILL), self.media, mi.Float(fluence.astype(np.float32).ravel()),
            triangles_per_cell=self.triangles_per_cell, samples=samples, seed=SEEDS_PER_RENDER * seed,
            max_depth=CAMERA_DEPTH,
        )  # fmt: skip
        columns, rows = scene.sensors()[0].film().size()
        return mi.TensorXf(image, shape=(int(rows), int(columns), 3))

    def to_string(self) -> str:
        """One line for logs."""
        return f"FluenceIntegrator[particles={self.particles}]"


def lights(scene: Any) -> list[str]:
    """Identifiers of the emitting shapes, in a fixed order with the outside light last."""
    names = [shape.id() for shape in scene.shapes() if shape.is_emitter()]
    return sorted(names, key=lambda name: (name == FLASHLIGHT, name))


def _shape(scene: Any, name: str) -> Any:
    return next((shape for shape in scene.shapes() if shape.id() == name), None)


def _chunks(particles: int) -> list[int]:
    return [min(CHUNK, particles - first) for first in range(0, particles, CHUNK)]


def integrator_settings(elastomer: Elastomer) -> dict[str, Any]:
    """Scene-dictionary entries of the integrator for one elastomer."""
    body, infill = elastomer.design.materials.body, elastomer.design.materials.infill
    return {
        "triangles_per_cell": max(elastomer.triangles_per_cell, 1),
        "body_ior": body.ior,
        "infill_ior": infill.ior if infill else body.ior,
        "body_absorption": body.absorption_per_mm,
        # Reduced coefficient: a cached fluence is exact for isotropic scattering only.
        "sigma_s": infill.sigma_s_per_mm * (1 - infill.anisotropy) if infill else 0.0,
        "sigma_a": infill.absorption_per_mm if infill else 0.0,
    }


mi.register_integrator("fluence", FluenceIntegrator)
