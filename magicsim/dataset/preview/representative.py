"""The frame that tells most about an episode, as a scene of its own that is quick to render."""

from typing import Any

from magicsim.dataset.recipes.draw import DrawnEpisode
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.scenes.scene import OutputSettings, SceneConfig
from magicsim.scenes.timeline import FrameState, timeline

SAMPLES, PARTICLES = 3, 10_000
SHRINK, ENLARGE = 4, 2
"""Factors by which a preview is rendered with fewer rows and columns, and shown larger."""
SPACING_MM = 2.0
"""Lattice of a preview: forces are rough, contact is where it will be."""


def telling_state(scene: SceneConfig) -> FrameState:
    """The last of the deepest (or nearest) states, or the middle one without an object."""
    states = timeline(scene)
    near = [state for state in states if state.gap_mm is not None]
    if not near:
        return states[len(states) // 2]
    deepest = min(state.gap_mm for state in near if state.gap_mm is not None)
    return [state for state in near if state.gap_mm == deepest][-1]


def preview_scene(episode: DrawnEpisode) -> SceneConfig:
    """One coarse frame of an episode: small, without friction, without the anchor that makes frames clean."""
    state = telling_state(episode.scene)
    keyframe = {"frame": 0, "flashlight": state.flashlight, "light_x_mm": state.light_x_mm}
    if state.gap_mm is not None:
        keyframe |= {name: getattr(state, name) for name in ("gap_mm", "x_mm", "y_mm", "twist_deg")}
    return _coarse(episode.scene.model_dump() | {"keyframes": [keyframe]})


def metering_scene(recipe: Recipe, episode: DrawnEpisode) -> SceneConfig:
    """The untouched sensor without tolerances, as coarse, which the exposure of all previews is metered on."""
    own = {"design": recipe.design.model_dump(), "rig": recipe.rig.model_dump(), "object": None, "seed": recipe.seed}
    return _coarse(episode.scene.model_dump() | own | {"keyframes": [{"frame": 0}]})


def quality() -> str:
    """What a preview leaves out, in a line."""
    return (
        f"Preview: 1/{SHRINK} of the pixels a side, {SAMPLES} samples, {PARTICLES:,} particles, lattice nodes "
        f"{SPACING_MM:g} mm apart, no friction, exposure of the sensor without tolerances."
    )


def _coarse(data: dict[str, Any]) -> SceneConfig:
    camera, lattice, render = data["rig"]["camera"], data["design"]["lattice"], data["render"]
    camera |= {"compression": None}  # blocks of 8 pixels are large here
    camera |= {"rows": max(8, camera["rows"] // SHRINK), "columns": max(8, camera["columns"] // SHRINK)}
    camera["principal_offset_px"] = tuple(each / SHRINK for each in camera["principal_offset_px"])
    lattice |= {"spacing_mm": max(SPACING_MM, lattice["spacing_mm"] or 0.0), "cells_across": 0}
    samples, particles = min(SAMPLES, render["samples"]), min(PARTICLES, render["particles"])
    render |= {"samples": samples, "particles": particles, "anchor_samples": 0}
    data["contact"]["friction"] = 0.0
    data["output"] = OutputSettings.nothing()
    return SceneConfig.model_validate(data | {"references": 0})
