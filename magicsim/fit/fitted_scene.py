"""The scene of a fitted sensor, ready to simulate: constants, strengths of the lights and exposure put in."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import tomli_w

from magicsim.arrays import Array
from magicsim.fit.constants import with_values
from magicsim.fit.strengths import Strengths
from magicsim.folder import result_file
from magicsim.light.world.names import ENVIRONMENT, FLASHLIGHT
from magicsim.scenes.lamps import BRIGHTEST, FAINTEST
from magicsim.scenes.scene import SceneConfig

DARKEST_GREY, BRIGHTEST_GREY = 1.0, 254.0
"""Exposure that a rig may aim at [grey levels]."""


def fitted_scene(
    scene: SceneConfig, values: Mapping[str, object], strengths: Strengths, untouched: Array
) -> SceneConfig:
    """A scene whose untouched sensor meters to the observed grey levels.

    Strengths are scaled so that the strips keep the rig's mean radiance: exposure and strength are known as a product
    alone. White balance is off, since the strengths now hold each colour's own level.

    Args:
        scene: The sensor that was fitted.
        values: Fitted constants by dotted field.
        strengths: Of its lights.
        untouched: Predicted grey levels of the untouched sensor, shape (rows, columns, 3).
    """
    strips = [strength for (name, _), strength in strengths.of.items() if name not in {FLASHLIGHT, ENVIRONMENT}]
    scale = len(strips) / sum(strips) if sum(strips) > 0 else 1.0

    def scaled(name: str, radiance: tuple[float, float, float]) -> list[float]:
        return [
            radiance[channel] * strengths.of.get((name, channel), 1 / scale) * scale for channel in range(len(radiance))
        ]

    rig, gamma = scene.rig, float(with_values(scene, values).rig.camera.gamma)
    signal = float(np.mean((np.clip(untouched, 0, 255) / 255) ** gamma))
    changed = with_values(scene, values)
    data = changed.rig.model_dump(mode="json")
    lights = [scaled(f"strip{place}", strip.radiance) for place, strip in enumerate(rig.strips)]
    *strip_radiances, flashlight, ambient = _allowed(
        [*lights, scaled(FLASHLIGHT, rig.flashlight.radiance), scaled(ENVIRONMENT, rig.ambient)]
    )
    for strip, radiance in zip(data["strips"], strip_radiances, strict=True):
        strip["radiance"] = radiance
    data["flashlight"]["radiance"], data["ambient"] = flashlight, ambient
    data["camera"]["white_balance"] = False
    data["camera"]["exposure_grey"] = float(np.clip(255 * signal ** (1 / gamma), DARKEST_GREY, BRIGHTEST_GREY))
    return with_values(changed, {"rig": data})


def _allowed(radiances: list[list[float]]) -> list[list[float]]:
    """All lights as a rig takes them: too faint ones off, and all of them dimmed alike where one is too bright."""
    dimmed = np.array(radiances) * min(1.0, BRIGHTEST / max(np.max(radiances), BRIGHTEST))
    return np.where(dimmed < FAINTEST, 0.0, dimmed).tolist()  # type: ignore[no-any-return]


def write_scene(path: Path, scene: SceneConfig, *, comment: str) -> None:
    """Writes a scene file; it appears whole or not at all.

    Args:
        path: TOML file.
        scene: Design and rig included.
        comment: What it is, a line or more.

    Raises:
        OutputError: It cannot be written.
    """
    head = "".join(f"# {line}\n" for line in comment.splitlines())
    with result_file(path) as partial:
        partial.write_text(head + tomli_w.dumps(scene.model_dump(mode="json", exclude_none=True)), encoding="utf-8")
