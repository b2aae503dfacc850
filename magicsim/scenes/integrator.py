"""The fluence estimator as a Mitsuba integrator, so that `mi.render(scene)` is all that a user needs."""

from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.scenes.backend import mi
from magicsim.scenes.camera_pass import gather_radiance
from magicsim.scenes.irradiance import IrradianceKernel, irradiance_kernel
from magicsim.scenes.light_field import LightField, total
from magicsim.scenes.light_pass import FIXED_POINT, cell_volumes_mm3, deposit_tracks
from magicsim.scenes.medium import Media, Shapes
from magicsim.scenes.names import BODY, ENVIRONMENT, FLASHLIGHT, INFILL, OBJECT

FloatArray = npt.NDArray[np.float64]
LIGHT_DEPTH = 400
"""Longest light path [interactions]; five times as long changes the mean radiance by less than 0.01 %."""
CAMERA_DEPTH = 200
"""Longest camera path [interactions]; four times as long changes the mean radiance by less than 0.01 %."""
CHUNK = 500_000
"""Particles traced at once: bounds the memory, does not change the result."""
NOTHING = SurfaceMesh(vertices=np.eye(3), faces=np.array([[0, 1, 2]], np.int32))
"""Stands for an absent object, so that arrays have a size."""
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
        self.object_color = np.array(properties.get("object_color", mi.ScalarColor3f(0.5)), np.float64)
        self._irradiance_kernel: IrradianceKernel | None = None
        self.media = Media(
            body_ior=properties["body_ior"],
            infill_ior=properties["infill_ior"],
            body_absorption=properties["body_absorption"],
            sigma_s=properties["sigma_s"],
            sigma_a=properties["sigma_a"],
        )

    def render(
        self,
        scene: Any,
        sensor: Any = 0,
        seed: int = 0,
        spp: int = 0,
        develop: bool = True,
        evaluate: bool = True,
    ) -> Any:
        """Renders the scene's first sensor; returns a tensor of shape (rows, columns, 3)."""
        fields = [self.light(scene, light, particles=self.share(scene), seed=seed) for light in lights(scene)]
        return self.gather(scene, total([self.darkness(scene), *fields]), samples=spp or 16, seed=seed)

    def darkness(self, scene: Any) -> LightField:
        """The light field of a scene without lights."""
        shapes = self._shapes(scene)
        return LightField(fluence=np.zeros((shapes.cells, 3)), irradiance=np.zeros((shapes.object_triangles, 3)))

    def share(self, scene: Any) -> int:
        """Particles of each light: all strips together get `particles`, an outside light gets as many again."""
        strips = sum(name not in {FLASHLIGHT, ENVIRONMENT} for name in lights(scene))
        return int(max(1, self.particles // max(1, strips)))

    def light(self, scene: Any, name: str, *, particles: int, seed: int) -> LightField:
        """Light that one emitter brings to every cell and to the object.

        Args:
            scene: The loaded scene.
            name: One of `lights(scene)`.
            particles: Number of particles.
            seed: Seed of the render; every light has a stream of its own.
        """
        shapes = self._shapes(scene)
        if shapes.object is None and (shapes.infill is None or self.media.sigma_s == 0):
            return self.darkness(scene)
        emitter = scene.environment() if name == ENVIRONMENT else _shape(scene, name).emitter()
        stream = SEEDS_PER_RENDER * seed + 1 + lights(scene).index(name)
        deposits, landed = np.zeros(3 * shapes.cells), np.zeros(3 * shapes.object_triangles)
        for first in range(0, particles, CHUNK):
            tracks = deposit_tracks(
                scene, emitter, shapes, self.media, first=first, particles=min(CHUNK, particles - first), seed=stream,
                max_depth=LIGHT_DEPTH,
            )  # fmt: skip
            deposits += tracks[0]
            landed += tracks[1]
        scale = 1 / (FIXED_POINT * particles)
        fluence = deposits.reshape(-1, 3) * scale / _volumes(shapes)[:, None]
        irradiance = self._kernel(shapes).irradiance(landed.reshape(-1, 3) * scale)
        return LightField(fluence=fluence, irradiance=irradiance)

    def gather(self, scene: Any, field: LightField, *, samples: int, seed: int, pattern: int = 0) -> Any:
        """Radiance image from cached light, a tensor of shape (rows, columns, 3)."""
        exitance = field.irradiance * self.object_color / np.pi
        image = gather_radiance(
            scene, self._shapes(scene), self.media, _flat(field.fluence), _flat(exitance),
            samples=samples, seed=SEEDS_PER_RENDER * seed, max_depth=CAMERA_DEPTH,
            pattern=pattern,
        )  # fmt: skip
        columns, rows = scene.sensors()[0].film().size()
        return mi.TensorXf(image, shape=(int(rows), int(columns), 3))

    def _shapes(self, scene: Any) -> Shapes:
        return Shapes(
            body=_shape(scene, BODY),
            infill=_shape(scene, INFILL),
            object=_shape(scene, OBJECT),
            triangles_per_cell=self.triangles_per_cell,
        )

    def _kernel(self, shapes: Shapes) -> IrradianceKernel:
        """Smoothing of the object's irradiance; the object is rigid, so once is enough."""
        if self._irradiance_kernel is None:
            self._irradiance_kernel = irradiance_kernel(_mesh(shapes.object) if shapes.object is not None else NOTHING)
        return self._irradiance_kernel

    def to_string(self) -> str:
        """One line for logs."""
        return f"FluenceIntegrator[particles={self.particles}]"


def lights(scene: Any) -> list[str]:
    """Names of the lights, in a fixed order: strips, flashlight, light from all around."""
    names = sorted(shape.id() for shape in scene.shapes() if shape.is_emitter())
    names.sort(key=lambda name: name == FLASHLIGHT)
    return names + ([ENVIRONMENT] if scene.environment() is not None else [])


def _shape(scene: Any, name: str) -> Any:
    return next((shape for shape in scene.shapes() if shape.id() == name), None)


def _mesh(shape: Any) -> SurfaceMesh:
    parameters = mi.traverse(shape)
    return SurfaceMesh(
        vertices=np.array(parameters["vertex_positions"], np.float64).reshape(-1, 3),
        faces=np.array(parameters["faces"]).reshape(-1, 3).astype(np.int32),
    )


def _volumes(shapes: Shapes) -> FloatArray:
    if shapes.infill is None:
        return np.ones(1)
    mesh = _mesh(shapes.infill)
    return cell_volumes_mm3(mesh.vertices, mesh.faces, shapes.cells)


def _flat(values: FloatArray) -> Any:
    return mi.Float(values.astype(np.float32).ravel())


def integrator_settings(elastomer: Elastomer, object_color: tuple[float, float, float]) -> dict[str, Any]:
    """Scene-dictionary entries of the integrator for one elastomer and the object's diffuse reflectance."""
    body, infill = elastomer.design.materials.body, elastomer.design.materials.infill
    return {
        "object_color": mi.ScalarColor3f(object_color),
        "triangles_per_cell": max(elastomer.triangles_per_cell, 1),
        "body_ior": body.ior,
        "infill_ior": infill.ior if infill else body.ior,
        "body_absorption": body.absorption_per_mm,
        # Reduced coefficient: a cached fluence is exact for isotropic scattering only.
        "sigma_s": infill.sigma_s_per_mm * (1 - infill.anisotropy) if infill else 0.0,
        "sigma_a": infill.absorption_per_mm if infill else 0.0,
    }


mi.register_integrator("fluence", FluenceIntegrator)
