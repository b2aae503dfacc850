"""Deformations that are solved once for one mechanical design: optical constants do not change them."""

from dataclasses import dataclass, field

from magicsim.deform.deformation import Deformation
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.plan import can_touch
from magicsim.simulation.sensor import Sensor

_OPTICAL_FIELDS = {"ior", "sigma_s_per_mm", "absorption_per_mm", "anisotropy"}


@dataclass(slots=True)
class Equilibria:
    """What has been solved, by design and state; the object and its friction must stay the same."""

    _solved: dict[tuple[str, FrameState], Deformation] = field(default_factory=dict)

    def of(self, sensor: Sensor, state: FrameState) -> Deformation:
        """Equilibrium of a sensor in a state, from rest.

        Raises:
            ConvergenceError: No valid equilibrium was found.
        """
        if not can_touch(state):
            return sensor.rest
        optics = {"materials": {"body": _OPTICAL_FIELDS, "infill": _OPTICAL_FIELDS}}
        key = (sensor.design.model_dump_json(exclude=optics), state)
        if key not in self._solved:
            self._solved[key] = sensor.deform(state, sensor.rest)
        return self._solved[key]
