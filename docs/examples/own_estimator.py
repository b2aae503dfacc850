"""An estimator of your own: a Mitsuba integrator that sees the sensor's scene; this one tells how far surfaces are.

python docs/examples/own_estimator.py      # nearest and farthest first surface [mm], a minute
"""

import numpy as np
import numpy.typing as npt

from magicsim import Sensor, load_scene
from magicsim.light.backend import dr, mi
from magicsim.scenes.timeline import View


class FirstSurface(mi.SamplingIntegrator):
    """Distance along each pixel's ray, from 0.1 mm before the pinhole to the first surface [mm]; three times."""

    def sample(self, scene, sampler, ray, medium=None, active=True):  # noqa: ANN001, ANN201 - Mitsuba's signature
        """See `mitsuba.SamplingIntegrator.sample`."""
        del sampler, medium
        hit = scene.ray_intersect(ray, active)
        found = hit.is_valid() & active
        return mi.Color3f(dr.select(found, hit.t, 0.0)), found, []


mi.register_integrator("first_surface", FirstSurface)


def distances_mm(settings: list[str]) -> npt.NDArray[np.float32]:
    """Distances in the untouched sensor, shape (rows, columns) [mm]."""
    world = Sensor.for_scene(load_scene("rest", settings)).renderer.world(View())
    image = mi.render(world.scene, integrator=mi.load_dict({"type": "first_surface"}), spp=1)
    return np.asarray(image, np.float32)[..., 0]


if __name__ == "__main__":
    found = distances_mm([])
    print(found.min(), found.max())
