"""The assumed constants of design and rig that decide how a sensor looks, their ranges, and the scene that a fit gives.

Ranges of the materials are those that stand beside the values in `geometry/mini-magictac.toml` (acrylate and glycol
proxies); of the rig nothing was published, so its ranges are our own and wide.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import log
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomli_w

from magicsim.arrays import Array
from magicsim.config.models import validate
from magicsim.errors import ConfigError, unknown_choice
from magicsim.fit.strengths import Strengths
from magicsim.folder import result_file
from magicsim.light.world.names import ENVIRONMENT, FLASHLIGHT, RING
from magicsim.scenes.rig import BRIGHTEST, FAINTEST
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
        """Where in the range a value lies, the inverse of `at`; `ConfigError` outside of it."""
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


def constants_named(names: Sequence[str]) -> dict[str, Constant]:
    """Some of `CONSTANTS`; `ConfigError` for an unknown name, or one that is given twice."""
    for name in names:
        if name not in CONSTANTS:
            raise ConfigError(unknown_choice("constant", name, CONSTANTS))
        if names.count(name) > 1:
            raise ConfigError(f"constant '{name}' is given twice")
    return {name: CONSTANTS[name] for name in names}


def with_values(scene: SceneConfig, values: Mapping[str, object]) -> SceneConfig:
    """A scene with other values; `ConfigError` where a field is missing or does not allow its value."""
    data = scene.model_dump(mode="json")
    for path, value in values.items():
        for holder, key in _places(data, path):
            holder[key] = value
    return validate(SceneConfig, data, source="fitted scene")


def value_of(scene: SceneConfig, path: str) -> float:
    """The number that a scene has at a dotted field, of a list's entries the first; `ConfigError` without one."""
    places = _places(scene.model_dump(mode="json"), path)
    if not places:
        raise ConfigError(f"the scene has no {path}")
    holder, key = places[0]
    return float(holder[key])


def _places(data: Any, path: str) -> list[tuple[Any, Any]]:  # noqa: ANN401 - nested plain data
    """What holds a dotted field, and the field's key there; several with `EVERY`. `ConfigError` without one."""
    places: list[tuple[Any, Any]] = [([data], 0)]
    for part in path.split("."):
        held = [holder[key] for holder, key in places]
        if part == EVERY and all(isinstance(each, list) for each in held):
            places = [(each, number) for each in held for number in range(len(each))]
        elif all(isinstance(each, dict) and part in each for each in held):
            places = [(each, part) for each in held]
        else:
            raise ConfigError(f"the scene has no {path}")
    return places


DARKEST_GREY, BRIGHTEST_GREY = 1.0, 254.0
"""Exposure that a rig may aim at [grey levels]."""


def fitted_scene(
    scene: SceneConfig, values: Mapping[str, object], strengths: Strengths, untouched: Array
) -> SceneConfig:
    """A scene whose untouched sensor meters to grey levels of the whole image, `untouched`, shape (rows, columns, 3).

    Strengths are scaled so that the lamps keep the rig's mean radiance: exposure and strength are known as a product
    alone. White balance is off, since the strengths now hold each colour's own level.
    """
    strips = [strength for (name, _), strength in strengths.items() if name not in {FLASHLIGHT, ENVIRONMENT}]
    scale = len(strips) / sum(strips) if sum(strips) > 0 else 1.0

    def scaled(name: str, radiance: tuple[float, float, float]) -> list[float]:
        return [
            radiance[channel] * strengths.get((name, channel), 1 / scale) * scale for channel in range(len(radiance))
        ]

    rig, changed = scene.rig, with_values(scene, values)
    gamma = changed.rig.camera.gamma
    signal = float(np.mean((np.clip(untouched, 0, 255) / 255) ** gamma))
    data = changed.rig.model_dump(mode="json")
    tables = {f"strip{place}": strip for place, strip in enumerate(data["strips"])}
    tables |= {f"led{place}": led for place, led in enumerate(data["leds"])} | {FLASHLIGHT: data["flashlight"]}
    tables |= {RING: data["ring"]} if rig.ring is not None else {}
    lights = [scaled(name, table["radiance"]) for name, table in tables.items()]
    *radiances, data["ambient"] = _allowed([*lights, scaled(ENVIRONMENT, rig.ambient)])
    for table, radiance in zip(tables.values(), radiances, strict=True):
        table["radiance"] = radiance
    data["camera"]["white_balance"] = False
    data["camera"]["exposure_grey"] = float(np.clip(255 * signal ** (1 / gamma), DARKEST_GREY, BRIGHTEST_GREY))
    return with_values(changed, {"rig": data})


def _allowed(radiances: list[list[float]]) -> list[list[float]]:
    """All lights as a rig takes them: too faint ones off, and all of them dimmed alike where one is too bright."""
    dimmed = np.array(radiances) * min(1.0, BRIGHTEST / max(np.max(radiances), BRIGHTEST))
    return np.where(dimmed < FAINTEST, 0.0, dimmed).tolist()  # type: ignore[no-any-return]


def write_scene(path: Path, scene: SceneConfig, *, comment: str) -> None:
    """Writes a scene file; it appears whole or not at all."""
    head = "".join(f"# {line}\n" for line in comment.splitlines())
    with result_file(path) as partial:
        partial.write_text(head + tomli_w.dumps(scene.model_dump(mode="json", exclude_none=True)), encoding="utf-8")
