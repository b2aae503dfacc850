"""The frame that tells most about an episode, as a scene of its own that is quick to render."""

from magicsim.dataset.draw import DrawnEpisode
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import FrameState, timeline

SAMPLES, PARTICLES = 3, 20_000
SHRINK = 2
"""Factor by which a preview has fewer rows and columns."""
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
    scene, state = episode.scene, telling_state(episode.scene)
    data = scene.model_dump()
    camera, lattice = data["rig"]["camera"], data["design"]["lattice"]
    camera |= {"rows": max(8, camera["rows"] // SHRINK), "columns": max(8, camera["columns"] // SHRINK)}
    camera["principal_offset_px"] = tuple(each / SHRINK for each in camera["principal_offset_px"])
    lattice |= {"spacing_mm": max(SPACING_MM, lattice["spacing_mm"] or 0.0), "cells_across": 0}
    samples, particles = min(SAMPLES, scene.render.samples), min(PARTICLES, scene.render.particles)
    data["render"] |= {"samples": samples, "particles": particles, "anchor_samples": 0}
    data["contact"]["friction"] = 0.0
    data["output"] = dict.fromkeys(data["output"], False)
    keyframe = {"frame": 0, "flashlight": state.flashlight, "light_x_mm": state.light_x_mm}
    if state.gap_mm is not None:
        keyframe |= {name: getattr(state, name) for name in ("gap_mm", "x_mm", "y_mm", "twist_deg")}
    return SceneConfig.model_validate(data | {"references": 0, "keyframes": [keyframe]})
