"""Episodes whose press ends at a force: their depth, found by pressing, in the place of the deepest one."""

from dataclasses import replace

from magicsim.dataset.recipes.draw import DrawnEpisode
from magicsim.deform.indentation.force import press_to_force
from magicsim.errors import ConfigError
from magicsim.scenes.scene import Keyframe


def at_force(episode: DrawnEpisode) -> DrawnEpisode:
    """The episode with keyframes that press as deep as its force does; itself where it has none.

    Raises:
        ConfigError: The object does not reach the force before the depth limit.
        MagicsimError: The press has no valid answer.
    """
    scene, force = episode.scene, episode.force_n
    pressed = [keyframe for keyframe in scene.keyframes if keyframe.gap_mm is not None and keyframe.gap_mm < 0]
    if force is None or scene.object is None or not pressed:
        return episode
    deepest = max(-(keyframe.gap_mm or 0.0) for keyframe in pressed)
    found = press_to_force(
        scene.design, scene.object, force, deepest_mm=deepest, x_mm=pressed[0].x_mm, y_mm=pressed[0].y_mm,
        friction=scene.contact.friction, max_iterations=scene.contact.max_iterations,
    )  # fmt: skip
    if episode.must_reach and not found.is_met:
        raise ConfigError(
            f"force_n = {force:.3g} is not reached: '{scene.object.kind}' presses with {found.force_n:.3g} N at the "
            f"depth limit of {found.depth_mm:.3g} mm; lower paths.force_n, or set paths.depth_mm beside it"
        )

    def scaled(keyframe: Keyframe) -> Keyframe:
        if keyframe.gap_mm is None or keyframe.gap_mm >= 0:
            return keyframe
        return keyframe.model_copy(update={"gap_mm": round(keyframe.gap_mm * found.depth_mm / deepest, 9)})

    keyframes = tuple(map(scaled, scene.keyframes))
    return replace(episode, scene=scene.model_copy(update={"keyframes": keyframes}))
