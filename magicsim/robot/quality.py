"""How finely a live sensor solves and renders: in full, or as a control loop can wait for."""

from dataclasses import dataclass, field
from typing import Any, Literal

from magicsim.config.models import validate
from magicsim.errors import ConfigError, unknown_choice
from magicsim.light.records.untouched import OPTICAL_SETTINGS
from magicsim.scenes.scene import SceneConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class Quality:
    """What a scene's own settings are replaced by."""

    name: str
    solve: Literal["full", "control"] = "full"
    """Lattice and solver, see `contact.quality`; full keeps the scene's own."""
    render: dict[str, Any] = field(default_factory=dict)
    """Settings of `render`; the smaller number is taken where the scene's own is coarser still."""
    bounds: dict[str, Any] = field(default_factory=dict)
    """Bounds of what `render` leaves out; the larger number is taken where the scene's own is coarser still."""
    output: dict[str, Any] = field(default_factory=dict)

    def applied(self, scene: SceneConfig) -> SceneConfig:
        """The scene as it is solved and rendered at this quality; `ConfigError` where a coarser one is not allowed."""
        if self.solve == "full" and not (self.render or self.bounds or self.output):
            return scene
        data = scene.model_dump()
        if self.solve != "full":
            data["contact"]["quality"] = self.solve
        data["output"] |= self.output
        # Frames of the fast tier cost no more with a careful untouched image.
        given, kept = data["render"], OPTICAL_SETTINGS if scene.render.tier == "fast" else frozenset()
        for coarser, values in ((min, self.render), (max, self.bounds)):
            given |= {name: coarser(value, given[name]) for name, value in values.items() if name not in kept}
        return validate(SceneConfig, data, source=f"quality '{self.name}'")


FULL_QUALITY = Quality(name="full")
"""The scene's own settings, to the solver's own tolerances."""
CONTROL_QUALITY = Quality(
    name="control",
    solve="control",
    render={"samples": 1, "particles": 8_000, "anchor_samples": 16, "anchor_particles": 400_000},
    bounds={"light_change": 0.025, "facet_mm": 1.0},
    output={"contact_mask": False, "displacements": False, "depth_map": False},
)
"""For control loops: coarser equilibria (`deform.quality`), a fifth of the triangles, one camera sample a pixel, a
third of the particles, which are traced in contact only where that changes light by some per cent, and no masks.

Pixels twice as large would be ready sooner, and their grain is taken for touches."""
QUALITIES = {each.name: each for each in (FULL_QUALITY, CONTROL_QUALITY)}


def find_quality(quality: str | Quality) -> Quality:
    """A quality by its name, or itself; `ConfigError` for another name."""
    if isinstance(quality, Quality):
        return quality
    if quality not in QUALITIES:
        raise ConfigError(unknown_choice("quality", quality, QUALITIES))
    return QUALITIES[quality]
