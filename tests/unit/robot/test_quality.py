"""The quality for control loops: coarser, within what it promises, and not drifting away."""

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.light.records.untouched import untouched_key
from magicsim.robot.live import live_sensor
from magicsim.robot.quality import CONTROL_QUALITY, FULL_QUALITY, QUALITIES, find_quality
from magicsim.scenes.scene import load_scene

from .conftest import BLOCK, RANGE

LARGEST_ERROR = 0.05
"""Of a force along a path, in units of its largest: five times the residual that ends a load step."""


def test_full_is_the_scene_itself():
    scene = load_scene("grip")
    assert FULL_QUALITY.applied(scene) is scene
    assert find_quality("full") is FULL_QUALITY
    assert find_quality(CONTROL_QUALITY) is CONTROL_QUALITY


def test_control_is_coarser_and_never_finer_than_the_scene():
    scene = load_scene("grip", ["render.particles=500"])
    found = CONTROL_QUALITY.applied(scene)
    assert found.render.samples < scene.render.samples
    assert found.render.particles == 500
    assert found.render.light_change > scene.render.light_change
    assert CONTROL_QUALITY.applied(load_scene("grip", ["render.light_change=0.5"])).render.light_change == 0.5
    assert found.contact == scene.contact.model_copy(update={"quality": "control"})
    assert found.design == scene.design
    assert found.render.facet_mm > scene.render.facet_mm
    assert found.rig == scene.rig
    assert found.object == scene.object


def test_on_the_fast_tier_the_untouched_image_is_the_careful_one():
    scene = load_scene("grip", ["render.tier=fast"])
    found = CONTROL_QUALITY.applied(scene)
    assert found.contact.quality == "control"
    assert untouched_key(found.design, found.rig, found.render) == untouched_key(scene.design, scene.rig, scene.render)
    assert found.render.samples == 1


def test_frames_for_control_hold_no_labels_that_take_time():
    with live_sensor("grip", BLOCK, workspace=RANGE, quality="control") as live:
        live.move_to(gap_mm=-0.2)
        labels = live.frame().labels
    assert (labels.contact_mask, labels.displacements_mm, labels.depth_map_mm) == (None, None, None)


def test_unknown_quality_names_the_others():
    with pytest.raises(ConfigError, match=r"unknown quality 'fast'.*control") as error:
        live_sensor("grip", quality="fast")
    assert all(name in str(error.value) for name in QUALITIES)


def test_forces_of_many_small_steps_stay_near_those_in_full():
    poses = [(-0.2, 0.0), (-0.4, 0.0), (-0.5, 0.0), (-0.5, 0.1), (-0.5, 0.2), (-0.5, 0.3), (-0.3, 0.3)]
    forces, iterations = {}, {}
    for quality in QUALITIES:
        with live_sensor("grip", BLOCK, workspace=RANGE, quality=quality) as live:
            found = []
            iterations[quality] = 0
            for gap, x in poses:
                live.move_to(gap_mm=gap, x_mm=x)
                found.append(live.truth.force_n)
                iterations[quality] += live.deformation.iterations
            live.move_to(gap_mm=1.0)
            assert live.truth.force_n == (0.0, 0.0, 0.0)
            forces[quality] = np.array(found)
    error = np.linalg.norm(forces["control"] - forces["full"], axis=1).max()
    assert error < LARGEST_ERROR * np.linalg.norm(forces["full"], axis=1).max()
    assert iterations["control"] < 0.7 * iterations["full"]
