"""The assumed constants of design and rig that decide how a sensor looks, with the ranges that are assumed of them.

Ranges of the materials are those that stand beside the values in `geometry/mini-magictac.toml` (acrylate and glycol
proxies); of the rig nothing was published, so its ranges are our own and wide.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import log
from typing import Any, Literal

from magicsim.config.models import validate
from magicsim.errors import ConfigError, unknown_choice
from magicsim.scenes.scene import SceneConfig

EVERY = "*"
"""Stands in a path for all entries of a list."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Constant:
    """One assumed number."""

    path: str
    """Dotted field of a scene."""
    low: float
    high: float
    """Ends of the assumed range, in the field's unit."""
    scale: Literal["linear", "log"] = "linear"
    """Whether values or their logarithms are spread evenly over the range."""

    def at(self, share: float) -> float:
        """The value at a share of the range, 0 at its low end and 1 at its high one."""
        if self.scale == "log":
            return float(self.low * (self.high / self.low) ** share)
        return float(self.low + share * (self.high - self.low))

    def share(self, value: float) -> float:
        """Where in the range a value lies; the inverse of `at`.

        Raises:
            ConfigError: Outside the range.
        """
        if not self.low <= value <= self.high:
            msg = f"{self.path} = {value:g} is not allowed: must be in its assumed range, {self.low:g} to {self.high:g}"
            raise ConfigError(msg)
        if self.scale == "log":
            return log(value / self.low) / log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


CONSTANTS: Mapping[str, Constant] = {
    "body_ior": Constant(path="design.materials.body.ior", low=1.47, high=1.51),
    "infill_ior": Constant(path="design.materials.infill.ior", low=1.43, high=1.49),
    "infill_scattering": Constant(path="design.materials.infill.sigma_s_per_mm", low=0.03, high=0.9, scale="log"),
    "body_scattering": Constant(path="design.materials.body.sigma_s_per_mm", low=0.0, high=0.1),
    "body_absorption": Constant(path="design.materials.body.absorption_per_mm", low=0.002, high=0.02, scale="log"),
    "infill_absorption": Constant(path="design.materials.infill.absorption_per_mm", low=0.001, high=0.01, scale="log"),
    "gel_scattering": Constant(path="design.materials.body.sigma_s_per_mm", low=0.1, high=5.0, scale="log"),
    "gel_absorption": Constant(path="design.materials.body.absorption_per_mm", low=1e-4, high=0.1, scale="log"),
    "gel_poisson": Constant(path="design.materials.body.poisson_ratio", low=0.45, high=0.4995),
    "coat_reflectance": Constant(path="design.coat.color.*", low=0.0, high=0.5),
    "press_gap": Constant(path="keyframes.*.gap_mm", low=-2.4, high=-0.6),
    "ring_radius": Constant(path="rig.ring.radius_mm", low=12.0, high=30.0),
    "ring_gap": Constant(path="rig.ring.gap_mm", low=1.0, high=25.0),
    "wall": Constant(path="design.wall_mm", low=0.1, high=0.2),
    "strip_margin": Constant(path="rig.strips.*.margin_mm", low=0.2, high=2.0),
    "strip_reflectance": Constant(path="rig.strips.*.reflectance", low=0.0, high=0.8),
    "lens": Constant(path="rig.lens.thickness_mm", low=0.5, high=4.0),
    "camera_distance": Constant(path="rig.camera.distance_mm", low=15.0, high=40.0),
    "vignetting": Constant(path="rig.camera.vignetting", low=0.0, high=0.6),
    "exposure": Constant(path="rig.camera.exposure_grey", low=30.0, high=150.0),
    "gamma": Constant(path="rig.camera.gamma", low=1.0, high=2.4),
    "full_well": Constant(path="rig.camera.full_well_e", low=2e4, high=2e6, scale="log"),
    "read_noise": Constant(path="rig.camera.read_noise_e", low=10.0, high=300.0, scale="log"),
}
"""The constants that a fit knows by name; `docs/hardware.md` has all that are assumed. The scattering of the infill is
a reduced coefficient, sigma_s (1 - g)."""


def named(names: Sequence[str]) -> dict[str, Constant]:
    """Some of `CONSTANTS`.

    Raises:
        ConfigError: An unknown name, or one that is given twice.
    """
    for name in names:
        if name not in CONSTANTS:
            raise ConfigError(unknown_choice("constant", name, CONSTANTS))
        if names.count(name) > 1:
            msg = f"constant '{name}' is given twice"
            raise ConfigError(msg)
    return {name: CONSTANTS[name] for name in names}


def with_values(scene: SceneConfig, values: Mapping[str, object]) -> SceneConfig:
    """A scene with other values.

    Args:
        scene: What happens, on which sensor.
        values: By dotted field; `*` stands for all entries of a list.

    Raises:
        ConfigError: No such field, or a value that it does not allow.
    """
    data = scene.model_dump(mode="json")
    for path, value in values.items():
        _put(data, path.split("."), value, path)
    return validate(SceneConfig, data, source="fitted scene")


def value_of(scene: SceneConfig, path: str) -> float:
    """The number that a scene has at a dotted field, of a list's entries the first.

    Raises:
        ConfigError: No such field.
    """
    found: Any = scene.model_dump(mode="json")
    for part in path.split("."):
        if part == EVERY and isinstance(found, list) and found:
            found = found[0]
        elif isinstance(found, dict) and part in found:
            found = found[part]
        else:
            msg = f"the scene has no {path}"
            raise ConfigError(msg)
    return float(found)


def _put(data: Any, parts: list[str], value: object, path: str) -> None:  # noqa: ANN401 - nested plain data
    for place, part in enumerate(parts[:-1]):
        if part == EVERY:
            for each in data:
                _put(each, parts[place + 1 :], value, path)
            return
        data = data.get(part) if isinstance(data, dict) else None
    if isinstance(data, list) and parts[-1] == EVERY:
        data[:] = [value] * len(data)
        return
    if not isinstance(data, dict):
        msg = f"the scene has no {path}"
        raise ConfigError(msg)
    data[parts[-1]] = value
