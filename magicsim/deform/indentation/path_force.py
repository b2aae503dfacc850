"""What an object does to a sensor at the places of its path."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class PathForce:
    """One place of a path, solved."""

    depth_mm: float
    """Depth from first contact [mm]."""
    shear_mm: tuple[float, float]
    """Motion along x and y since then [mm]."""
    twist_deg: float
    """Rotation about z since then [degrees]."""
    time_s: float | None
    """Since first contact [s]; None on a quasi-static path, which has no time."""
    force_n: Vector
    """Force of the object on the sensor [N]; a press is +z."""
    torque_nmm: Vector
    """Torque about the origin [N mm]."""
    contact_area_mm2: float
    """Deformed area that touches, see `Deformation` [mm2]."""

    def as_dict(self) -> dict[str, Any]:
        """The keys of the command line's JSON; no time where there is none."""
        return {key: value for key, value in asdict(self).items() if value is not None}


def as_vector(values: npt.NDArray[np.float64]) -> Vector:
    """Three numbers of an array, shape (3,)."""
    x, y, z = values.tolist()
    return (x, y, z)
