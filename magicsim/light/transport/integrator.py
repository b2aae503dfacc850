"""The light of a block as a Mitsuba integrator, `mi.render(world.scene, integrator=FluenceIntegrator(world, ...))`."""

from typing import Any

from magicsim.light.backend import mi
from magicsim.light.transport.lit_world import LitWorld

SAMPLES = 16
"""Camera samples a pixel where `mi.render` is not told how many."""


class FluenceIntegrator(mi.CppADIntegrator):  # type: ignore[misc]
    """Renders a world's own scene; holds the world, which knows nothing of it."""

    def __init__(self, world: LitWorld, *, particles: int) -> None:
        """For the state in which the world is when an image is asked for."""
        super().__init__(mi.Properties())
        self._world, self._particles = world, particles

    def render(
        self, scene: Any, sensor: Any = 0, seed: int = 0, spp: int = 0, develop: bool = True, evaluate: bool = True
    ) -> Any:
        """Image of the world's sensor, a tensor of shape (rows, columns, 3)."""
        return self._world.image(self._world.lights, samples=spp or SAMPLES, particles=self._particles, seed=seed)
