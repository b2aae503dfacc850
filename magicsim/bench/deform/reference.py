"""The reference solution: its file, and what it holds.

`magicsim.bench.deform.recompute` writes the file with an independent finite-element code; comparing needs the file
alone.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from magicsim.arrays import Array
from magicsim.config.documents import read_json
from magicsim.errors import PresetError
from magicsim.folder import result_file

FILE = Path(__file__).with_name("reference_sphere_block.json")
DECIMALS = 6
"""Digits kept of a displacement in millimetres."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceDepth:
    """The reference at one depth, each value with an estimate of its own error."""

    depth_mm: float
    force_n: float
    """Extrapolated to a rigid contact."""
    force_error_n: float
    contact_area_mm2: float
    """Deformed area inside the sphere, extrapolated likewise."""
    contact_area_error_mm2: float
    surface_mm: Array
    """Displacement of the problem's sample points, shape (points, 3) [mm]."""
    surface_error_mm: float
    """Root mean square over the sample points."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """All depths, and how they were found."""

    depths: tuple[ReferenceDepth, ...]
    method: str
    """One sentence."""
    command: str
    """What writes the file."""

    def at(self, depth_mm: float) -> ReferenceDepth:
        """The reference at a depth.

        Raises:
            PresetError: The file does not hold that depth.
        """
        for depth in self.depths:
            if np.isclose(depth.depth_mm, depth_mm):
                return depth
        held = ", ".join(f"{depth.depth_mm:g}" for depth in self.depths)
        msg = f"the reference holds no depth of {depth_mm:g} mm; available: {held}"
        raise PresetError(msg)


def reference_path() -> Path:
    """Where the shipped reference is."""
    return FILE


def load_reference(path: Path | None = None) -> Reference:
    """Reads a reference.

    Args:
        path: The file; the shipped one by default.

    Raises:
        PresetError: No such file.
    """
    file = path or reference_path()
    if not file.is_file():
        msg = f"reference '{file}' does not exist; write it with --recompute (needs `pip install magicsim[reference]`)"
        raise PresetError(msg)
    data = read_json(file)
    return Reference(
        depths=tuple(
            ReferenceDepth(**(values | {"surface_mm": np.array(values["surface_mm"], float).reshape(-1, 3)}))
            for values in data["depths"]
        ),
        method=data["method"],
        command=data["command"],
    )


def save_reference(reference: Reference, path: Path) -> None:
    """Writes a reference as JSON, displacements rounded to `DECIMALS`."""
    depths = [
        {
            "depth_mm": depth.depth_mm,
            "force_n": depth.force_n,
            "force_error_n": depth.force_error_n,
            "contact_area_mm2": depth.contact_area_mm2,
            "contact_area_error_mm2": depth.contact_area_error_mm2,
            "surface_error_mm": depth.surface_error_mm,
            "surface_mm": np.round(depth.surface_mm.ravel(), DECIMALS).tolist(),
        }
        for depth in reference.depths
    ]
    data = {"method": reference.method, "command": reference.command, "depths": depths}
    with result_file(path) as partial:
        partial.write_text(json.dumps(data) + "\n", encoding="utf-8")
