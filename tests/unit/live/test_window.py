"""The window without a browser: what its buttons and sliders do while the worker is at something else."""

from dataclasses import replace

import pytest
import viser

from magicsim.judge.recorded import read_episode
from magicsim.live.controls import Controls
from magicsim.live.server import close_server, open_server
from magicsim.live.sight import Wish
from magicsim.live.window import LiveWindow
from magicsim.scenes.scene import load_scene

from .conftest import PORT, SPACE


@pytest.fixture
def controls():
    server: viser.ViserServer = open_server(PORT + 5, "test")
    yield Controls(server, SPACE, Wish(exposure_grey=90.0, design=(0.8, 5.0, 0.8, 0.1)), lambda _: None)
    close_server(server)


def test_design_that_is_being_chosen_stays_until_it_is_built_or_refused(controls: Controls):
    skin, before = controls._design[0], controls.wish
    skin.value = 1.5
    controls.follow(replace(before, gap_mm=1.0), is_last=True)  # a motion, or something that passes in the room
    assert skin.value == 1.5
    controls._ask_for_design()
    controls.follow(replace(before, gap_mm=1.0), is_last=True)  # refused
    assert skin.value == 0.8
    controls.follow(replace(before, design=(1.2, 5.0, 0.8, 0.1)), is_last=True)  # built on request of other code
    assert skin.value == 1.2


def test_exposure_of_a_scene_beyond_the_slider_widens_it(controls: Controls):
    server: viser.ViserServer = open_server(PORT + 7, "test")
    bright = Controls(server, SPACE, replace(controls.wish, exposure_grey=230.0), lambda _: None)
    (slider,) = (handle for handle, name, _ in bright._followed if name == "exposure_grey")
    assert (slider.max, slider.value) == (230.0, 230.0)
    close_server(server)


def test_recording_begins_with_the_lights_that_were_asked_for_before_it(window: LiveWindow, until):
    window.ask(replace(window.wish, exposure_grey=150.0))
    window._toggle_recording()
    until(lambda: window._recording is not None and window.busy is None)
    window.ask(replace(window.wish, exposure_grey=60.0))  # refused during a recording
    assert window.wish.exposure_grey == 150.0
    window._toggle_recording()
    (folder,) = window.folder.iterdir()
    assert load_scene(folder / "config.toml").rig.camera.exposure_grey == 150.0
    read = read_episode(folder)
    assert read.references[0].mean() == pytest.approx(read.frames[0].mean(), rel=0.1)


def test_recording_that_is_stopped_before_its_first_frame_says_so(window: LiveWindow):
    window._toggle_recording()
    window._toggle_recording()
    assert not window._is_recording


def test_closing_writes_the_recording_that_goes_on(tiny_scene, until, tmp_path):
    heard: list[str] = []
    with LiveWindow(tiny_scene, folder=tmp_path, port=PORT + 6, workspace=SPACE, told=heard.append) as window:
        window._toggle_recording()  # before the sensor is ready
        until(lambda: window._recording is not None and window.busy is None)
    (folder,) = tmp_path.iterdir()
    assert len(read_episode(folder).frames) == 1
    assert heard[-1] == f"1 frames in {folder.name}"
