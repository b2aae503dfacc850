"""Which colours a coat and markers may have in a scene, and what a coat hides."""

import pytest

from magicsim.errors import ConfigError
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.simulation.plan import as_seen

RED_DOTS = 'design.markers={kind="dots",pitch_mm=2.0,diameter_mm=1.0,color=[0.5,0.1,0.1]}'


def test_coloured_markers_on_a_see_through_face_need_frames_without_anchor():
    with pytest.raises(ConfigError, match=r"markers.color = \[0.5, 0.1, 0.1\] is not allowed: must be grey"):
        load_scene("rest", [RED_DOTS])
    load_scene("rest", [RED_DOTS, "render.anchor_samples=0"])
    load_scene("gelsight-type", [RED_DOTS])


def test_coat_hides_what_does_not_touch_and_the_flashlight():
    scene = load_scene("gelsight-type")
    for state in timeline(scene):
        seen = as_seen(scene.design, state)
        touches = state.gap_mm is not None and state.gap_mm < 0
        assert seen == (state if touches else UNTOUCHED)
    clear = load_scene("marker-type")
    assert [as_seen(clear.design, state) for state in timeline(clear)] == timeline(clear)
