"""Units in the names of columns, which have to be those that a description counts in."""

import re
from collections.abc import Iterator

import numpy as np

from magicsim.dataset.real.description import Description

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0}
NEWTONS = {
    "N": 1.0, "mN": 1e-3, "cN": 1e-2, "kN": 1e3, "g": 9.80665e-3, "gf": 9.80665e-3, "kg": 9.80665, "kgf": 9.80665,
    "lbf": 4.4482216,
}  # fmt: skip
MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1e3, "um": 1e-3, "µm": 1e-3, "inch": 25.4}
UNITS = {
    "time_s": SECONDS, "force_n": NEWTONS, "gap_mm": MILLIMETRES, "depth_mm": MILLIMETRES, "place_mm": MILLIMETRES,
    "torque_nmm": {"Nmm": 1.0, "N mm": 1.0, "mNm": 1.0, "Nm": 1e3, "N m": 1e3},
    "contact_area_mm2": {"mm2": 1.0, "mm²": 1.0, "cm2": 100.0, "cm²": 100.0, "m2": 1e6},
    "twist_deg": {"deg": 1.0, "°": 1.0, "rad": 180 / np.pi},
}  # fmt: skip
"""What one of each unit is in that of a label."""
CLOSE = 1e-3
_UNIT = re.compile(r"[(\[]\s*([^)\]]+?)\s*[)\]]$|_([A-Za-zµ°²2]+)$")
"""`force (mN)`, `force [mN]`, `force_mN`."""


def told_of_units(description: Description) -> Iterator[str]:
    """One line for each label whose column names a unit that the description does not bring into its own."""
    for field, units in UNITS.items():
        named = getattr(description.columns, field)
        names = (named,) if isinstance(named, str) else named or ()
        given = np.abs(np.atleast_1d(getattr(description.scale, field)))
        for name in names:
            found = _UNIT.search(name.strip())
            unit = (found[1] or found[2]) if found is not None else ""
            if unit in units and not np.allclose(given, units[unit], rtol=CLOSE, atol=0):
                yield f": column '{name}' is in {unit} by its name: set scale.{field} = {units[unit]:.7g}"
                break
