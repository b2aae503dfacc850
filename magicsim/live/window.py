"""The window itself: viser's page on one side, the worker with its sensor on the other."""

import threading
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np

from magicsim.errors import MagicsimError
from magicsim.folder import check_place
from magicsim.live.controls import Controls, Course, View3D
from magicsim.live.recording import Recording, recording_name
from magicsim.live.server import close_server, open_server
from magicsim.live.session import Session, Worker
from magicsim.live.sight import Sight, Wish, force_lines, frame_picture, state_line, verdict_table
from magicsim.robot.quality import Quality, find_quality
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig
from magicsim.simulation.episode import SimulatedFrame

TITLE = "magicsim live"
PORT = 8321
TICK_S = 0.5
"""Time between two looks at the clock [s]."""
PANEL_PX = 450
NOTHING_RECORDED = "nothing was recorded: move the object while recording, each frame that is shown is kept"
NO_FORCE = "<p style='margin:4px 0'>No contact solved yet.</p>"
HELP = (
    "<p class='help' style='margin:4px 8px'>Drag the arrows at the object, or hold <b>shift</b>: arrow keys move it, "
    "<b>P</b> presses, <b>L</b> lifts, <b>J</b> and <b>K</b> turn. Every control is reached with the Tab key too.</p>"
)


class LiveWindow(AbstractContextManager["LiveWindow"]):
    """A page on 127.0.0.1 that shows one sensor and moves its object."""

    def __init__(
        self, scene: SceneConfig, *, folder: Path = Path(), port: int = PORT, workspace: Workspace | None = None,
        quality: str | Quality = "control", told: Callable[[str], None] | None = None,
    ) -> None:  # fmt: skip
        """Opens the page; the sensor is built in the background.

        The next free port is taken where this one is not. Recordings get folders of their own; `told` hears what takes
        long, beside the page.

        Raises:
            ConfigError: viser is missing, or the quality is unknown.
            OutputError: No recording can be written in the folder.
        """
        check_place(folder / recording_name(1))
        space = workspace or Workspace(x_mm=(-4, 4), y_mm=(-4, 4), gap_mm=(-2, 20))
        self.folder, self.workspace, self._told = folder, space, told
        self._session = Session(scene, quality=find_quality(quality), workspace=space, told=self._tell)
        self._worker = Worker(self._session, self._show, self._refuse)
        self._shown_scene: SceneConfig | None = None
        self.sight: Sight | None = None
        """The last moment that was shown with its frame; None before the first."""
        self._refusal: str | None = None
        self._is_recording = False
        self._recording: Recording | None = None
        self._written = 0
        self._course = Course()
        self._ended = threading.Event()
        self._server = open_server(port, TITLE)
        self._lay_out(scene, space)
        threading.Thread(target=self._watch, name="magicsim-live-clock", daemon=True).start()
        self._worker.start()
        self._worker.ask(self._controls.wish)

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://127.0.0.1:{self._server.get_port()}"

    @property
    def busy(self) -> tuple[str, float] | None:
        """What is being done and for how long [s]; None when nothing is."""
        return self._worker.busy

    @property
    def wish(self) -> Wish:
        """What is asked for now."""
        return self._controls.wish

    def ask(self, wish: Wish) -> None:
        """Asks for something as the page does; the newest wish wins, and this never waits."""
        self._controls.ask(wish)

    def wait(self) -> None:
        """Waits until the window is closed by another thread."""
        self._ended.wait()

    def close(self) -> None:
        """Ends the page and the worker, and writes a recording that goes on; may be called again."""
        if not self._ended.is_set():
            self._ended.set()
            self._worker.stop()
            if self._recording is not None:
                self._tell(self._written_recording(self._recording))
            close_server(self._server)

    def __exit__(self, *_: object) -> None:
        self.close()

    def _lay_out(self, scene: SceneConfig, space: Workspace) -> None:
        gui, camera = self._server.gui, scene.rig.camera
        gui.configure_theme(dark_mode=False, show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(PANEL_PX)
        self._state = gui.add_html(state_line(("starting", 0.0), None))
        dark = np.zeros((camera.rows, camera.columns, 3), np.uint8)
        self._image = gui.add_html(frame_picture(dark, dark, gamma=camera.gamma))
        with gui.add_folder("Verdicts"):
            self._verdicts = gui.add_html(verdict_table({}))
        with gui.add_folder("Force"):
            self._forces = gui.add_html(NO_FORCE)
            self._plot = gui.add_uplot(
                self._course.columns(),
                (
                    {"label": "step"},
                    {"label": "normal [N]", "stroke": "#1f6feb"},
                    {"label": "tangential [N]", "stroke": "#d1242f"},
                ),
                scales={"x": {"time": False}},
                aspect=2.2,
            )
        with gui.add_folder("Recording"):
            self._record = gui.add_button("Record", hint="Keeps every frame until it is pressed again.")
            self._record.on_click(lambda _: self._toggle_recording())
            self._record_note = gui.add_html("<p style='margin:4px 8px'>Nothing recorded yet.</p>")
        self._controls = Controls(self._server, space, self._session.now, self._ask)
        self._view = View3D(self._server, space, self._controls.drag)
        gui.add_html(HELP)

    def _ask(self, wish: Wish) -> None:
        recording = self._recording
        if recording is not None and (_held(wish) != _held(recording.begun)):
            self._refuse("design, LEDs and exposure stay as they are during a recording: stop it first")
            begun = recording.begun
            kept = replace(
                wish, design=begun.design, led_strength=begun.led_strength, exposure_grey=begun.exposure_grey
            )
            self._controls.follow(kept, is_last=True)
            return
        self._worker.ask(wish)

    def _show(self, sight: Sight) -> None:
        """Puts a sight on the page; runs on the worker's thread."""
        self._refusal = sight.refusal
        self._show_block()
        self._view.show(sight)
        self._forces.content = force_lines(sight)
        if sight.frame is None:
            self._course.add(sight.force_n)
            self._plot.data = self._course.columns()
            return
        gamma = self._session.scene.rig.camera.gamma
        self._image.content = frame_picture(sight.frame.image, self._session.rest, gamma=gamma)
        self._verdicts.content = verdict_table(sight.verdicts)
        self._record_frame(sight.wish, sight.frame)
        self.sight = sight
        self._controls.follow(sight.wish, is_last=not self._worker.is_asked)
        self._state.content = state_line(None, self._refusal)

    def _show_block(self) -> None:
        scene = self._session.scene
        if scene is self._shown_scene:
            return
        thing = scene.object
        mesh, color = (thing.surface(), thing.color) if thing is not None else (None, (0.7, 0.7, 0.7))
        self._view.show_block(self._session.live.sensor.lattice, mesh, color)
        self._shown_scene = scene

    def _record_frame(self, wish: Wish, frame: SimulatedFrame) -> None:
        """Keeps a frame; the first one that no newer wish follows begins the recording. On the worker's thread."""
        recording = self._recording
        if self._is_recording and recording is None and not self._worker.is_asked:
            live = self._session.live
            recording = Recording(live.scene, self._session.references, live.sensor.printed, wish)
            self._recording = recording
        if recording is not None and _held(wish) == _held(recording.begun):
            recording.add(frame)
            self._note(f"Recording: {len(recording)} frames" + (", full" if recording.is_full else ""))

    def _toggle_recording(self) -> None:
        self._is_recording = not self._is_recording
        if self._is_recording:
            self._record.label = "Stop and save"
            self._note("Recording: 0 frames")
            self._worker.ask(self._controls.wish)
            return
        recording, self._recording = self._recording, None
        self._record.label = "Record"
        self._note(NOTHING_RECORDED if recording is None else self._written_recording(recording))

    def _written_recording(self, recording: Recording) -> str:
        """Writes a recording into a folder of its own, and says which, or why not."""
        self._written += 1
        target = self.folder / recording_name(self._written)
        try:
            recording.write(target, estimator=self._session.live.sensor.renderer.estimator)
        except MagicsimError as error:
            return str(error)
        return f"{len(recording)} frames in {target.name}"

    def _note(self, line: str) -> None:
        self._record_note.content = f"<p class='recorded' role='status' style='margin:4px 8px'>{escape(line)}</p>"

    def _refuse(self, why: str) -> None:
        self._refusal = why
        self._state.content = state_line(self._worker.busy, why)

    def _tell(self, line: str) -> None:
        self._worker.told(line)
        if self._told is not None:
            self._told(line)

    def _watch(self) -> None:
        """Keeps the line about what is going on up to date."""
        was_busy = False
        while not self._ended.wait(TICK_S):
            busy = self._worker.busy
            if busy is not None or was_busy:
                self._state.content = state_line(busy, self._refusal)
            was_busy = busy is not None


def _held(wish: Wish) -> tuple[object, ...]:
    return wish.design, wish.led_strength, wish.exposure_grey
