"""Episodes whose press ends at a force: their depth, found by pressing, in the place of the deepest one."""

from collections.abc import Sequence
from dataclasses import replace

from magicsim.dataset.recipes.draw import DrawnEpisode
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation.force import DIGITS, press_to_force
from magicsim.errors import ConfigError
from magicsim.geometry.indenter import Indenter
from magicsim.scenes.scene import Keyframe, SceneConfig
from magicsim.scenes.timeline import placed_in, timeline


def at_force(episode: DrawnEpisode) -> tuple[DrawnEpisode, Deformation | None]:
    """The episode with keyframes that press as deep as its force does, and the equilibrium at that depth.

    Itself where it has no force; no equilibrium where none is known.

    Raises:
        ConfigError: The object does not reach the force before the depth limit.
        MagicsimError: The press has no valid answer.
    """
    scene, force = episode.scene, episode.force_n
    deepest = max((-keyframe.gap_mm for keyframe in scene.keyframes if keyframe.gap_mm is not None), default=0.0)
    if force is None or scene.object is None or deepest <= 0:
        return episode, None
    found = press_to_force(
        scene.design, lambda depth: _touching(_pressed(scene, depth, deepest)), force, deepest_mm=deepest,
        friction=scene.contact.friction, quality=scene.contact.quality, max_iterations=scene.contact.max_iterations,
    )  # fmt: skip
    if episode.must_reach and not found.is_met:
        raise ConfigError(
            f"force_n = {force:.3g} is not reached: '{scene.object.kind}' presses with {found.force_n:.3g} N at the "
            f"depth limit of {found.depth_mm:.3g} mm; lower paths.force_n, or set paths.depth_mm beside it"
        )
    return replace(episode, scene=_pressed(scene, found.depth_mm, deepest)), found.state


def _pressed(scene: SceneConfig, depth_mm: float, deepest_mm: float) -> SceneConfig:
    """The scene pressed to a depth in place of its deepest one [mm]."""

    def scaled(keyframe: Keyframe) -> Keyframe:
        if keyframe.gap_mm is None or keyframe.gap_mm >= 0:
            return keyframe
        return keyframe.model_copy(update={"gap_mm": round(keyframe.gap_mm * depth_mm / deepest_mm, DIGITS)})

    return scene.model_copy(update={"keyframes": tuple(map(scaled, scene.keyframes))})


def _touching(scene: SceneConfig) -> Sequence[Indenter]:
    """The object where it is first as deep as ever, and then in all states that can touch, in order."""
    states = [state for state in timeline(scene) if state.can_touch]
    first = min(states, key=lambda state: state.gap_mm or 0.0)
    placed = (placed_in(state, scene.object, scene.design) for state in (first, *states))
    return [each for each in placed if each is not None]
