"""Simulates one scene up to the camera."""

from functools import lru_cache

import numpy as np

from magicsim.evaluate.take import Take
from magicsim.plan import plan_scene
from magicsim.scenes.renderer import Anchor
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation import Sensor, stream_states


def film_take(scene: SceneConfig) -> Take:
    """All states of a scene, every one that looks different rendered once.

    Raises:
        MagicsimError: The design, a deformation or an image is not valid.
    """
    sensor = Sensor(scene)
    kept = _anchors()
    key = _anchor_key(scene)
    if key in kept:
        sensor.renderer.adopt_anchor(kept[key])
    untouched = sensor.radiance(UNTOUCHED, sensor.rest)
    if sensor.renderer.estimator == "fluence" and scene.render.anchor_samples:
        kept.clear()  # one is enough: a suite's episodes of one seed follow each other
        kept[key] = sensor.renderer.anchor()
    frames = list(stream_states(sensor, plan_scene(scene), untouched))
    images, place = [untouched], {id(untouched): 0}
    for each in frames:
        if id(each.radiance) not in place:
            place[id(each.radiance)] = len(images)
            images.append(each.radiance)
    gaps = [each.state.gap_mm for each in frames]
    return Take(
        radiance=np.stack(images).astype(np.float32),
        state=np.array([place[id(each.radiance)] for each in frames], np.int32),
        is_reference=np.array([each.is_reference for each in frames], bool),
        gap_mm=np.array([np.nan if gap is None else gap for gap in gaps], np.float64),
        force_n=np.array([np.linalg.norm(each.deformation.force_n) for each in frames], np.float64),
        flashlight=np.array([each.state.flashlight for each in frames], bool),
    )


@lru_cache(maxsize=1)
def _anchors() -> dict[str, Anchor]:
    """The untouched state last rendered: it does not depend on the object, so one sensor's episodes share it."""
    return {}


def _anchor_key(scene: SceneConfig) -> str:
    return scene.model_copy(update={"object": None, "keyframes": ()}).model_dump_json(
        include={"design", "rig", "seed", "render"}
    )
