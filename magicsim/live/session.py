"""One live sensor, its scene, and the wishes of the window's user: carried out in order, refused in one line.

A thread solves and renders, so that the window never waits for it.
"""

import logging
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from magicsim.arrays import Array
from magicsim.config.documents import read_toml
from magicsim.config.models import apply_overrides, load_preset, validate
from magicsim.config.presets import find_preset, preset_names
from magicsim.errors import MagicsimError, PresetError, unknown_choice
from magicsim.geometry.design import MAX_DEPTH_SHARE, ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object
from magicsim.judge.verdicts import SensorDetector, fused_profiles
from magicsim.live.sight import DESIGN_FIELDS, Sight, Wish, design_values
from magicsim.robot.live import LiveSensor
from magicsim.robot.quality import Quality
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import UNTOUCHED, with_passing
from magicsim.simulation.episode import SimulatedFrame
from magicsim.waiting import Told

STAGE = "grip"
"""Scene that lends a design its rig, its object and the friction between them."""


def find_subject(
    name: str | Path, overrides: Sequence[str] = (), *, seed: int | None = None, object: str | None = None
) -> SceneConfig:
    """The scene of a window: that of a scene or a design, preset or file, perhaps with another object."""
    if _is_design(name):
        design = load_preset(ElastomerDesign, "design", name)
        data = load_scene(STAGE, seed=seed).model_dump()
        data["design"] = design.model_dump()
        scene = validate(SceneConfig, apply_overrides(data, list(overrides)), source=str(name))
    else:
        scene = load_scene(name, overrides, seed=seed)
    return scene if object is None else scene.model_copy(update={"object": parse_object(object)})


def _is_design(name: str | Path) -> bool:
    """Whether a name or file is a design and not a scene; `PresetError` where it is neither."""
    text = str(name)
    if text in preset_names("scene"):
        return False
    if text in preset_names("design"):
        return True
    if not (text.endswith(".toml") or "/" in text):
        choices = sorted({*preset_names("scene"), *preset_names("design")})
        raise PresetError(unknown_choice("scene or design", text, choices))
    return "keyframes" not in read_toml(find_preset("scene", name))


class Session:
    """The sensor of the window; used by one thread alone."""

    def __init__(self, scene: SceneConfig, *, quality: Quality, workspace: Workspace, told: Told) -> None:
        self.scene, self.quality, self.workspace = scene, quality, workspace
        self._told = told
        self._live: LiveSensor | None = None
        self._profiles: dict[str, SensorDetector | str] = {}
        self.references: tuple[SimulatedFrame, ...] = ()
        """Frames of the untouched sensor that the verdicts refer to."""
        self.rest: Array = np.zeros(())
        """Their mean, shape (rows, columns, 3) [grey levels]."""
        grey, has_object = scene.rig.camera.exposure_grey, scene.object is not None
        asked = Wish(design=design_values(scene.design), exposure_grey=grey, has_object=has_object)
        self.now = asked.pushed(workspace, gap_mm=0.0, x_mm=0.0, y_mm=0.0, twist_deg=0.0)
        """Where everything is."""

    @property
    def live(self) -> LiveSensor:
        """The sensor, built when it is first needed; errors are those of its design."""
        if self._live is None:
            live = self._built(self.scene, self.now)
            self._learn(live)
            self._live = live
        return self._live

    @property
    def pause_s(self) -> float | None:
        """Time after which the picture is another one by itself, as something passes in the room [s]; None without."""
        return None if self.scene.rig.moving is None else 1 / self.scene.frames_per_second

    def go(self, wish: Wish) -> Sight:
        """Carries a wish out as far as the lattice; what is refused leaves object and design as they were.

        The lattice has no frame yet, see `look`. `MagicsimError` where the first design cannot be built.
        """
        start, refusal = time.perf_counter(), None
        _ = self.live
        try:
            self._build(wish)
            self._light(wish)
            self._move(wish)
        except MagicsimError as error:
            refusal = str(error)
        return self._sight(refusal, solve_s=time.perf_counter() - start)

    def look(self, sight: Sight) -> Sight:
        """The sight with the camera's frame and the verdicts on it."""
        start = time.perf_counter()
        try:
            frame = self.live.frame()
        except MagicsimError as error:
            return replace(sight, refusal=str(error), light_s=time.perf_counter() - start)
        verdicts = {
            name: each if isinstance(each, str) else each.verdict(frame.image) for name, each in self._profiles.items()
        }
        return replace(sight, frame=frame, verdicts=verdicts, light_s=time.perf_counter() - start)

    def _build(self, wish: Wish) -> None:
        if wish.design == self.now.design:
            return
        values = self.scene.design.model_dump() | dict(zip(DESIGN_FIELDS, wish.design, strict=True))
        design = validate(ElastomerDesign, values, source="design")
        scene = validate(SceneConfig, self.scene.model_dump() | {"design": design.model_dump()}, source="design")
        fresh = self._built(scene, self.now)
        self._learn(fresh)
        if self._live is not None:
            self._live.close()
        self.scene, self._live = scene, fresh
        self.now = replace(self.now, design=design_values(design), has_object=False)

    def _built(self, scene: SceneConfig, wish: Wish) -> LiveSensor:
        self._told("building the block and its lattice")
        low, high = self.workspace.gap_mm
        space = replace(self.workspace, gap_mm=(max(low, -MAX_DEPTH_SHARE * scene.design.height_mm), high))
        live = LiveSensor(scene, workspace=space, quality=self.quality, told=self._told)
        live.set_exposure_grey(wish.exposure_grey)
        live.set_led_strength(*wish.led_strength)
        return live

    def _learn(self, live: LiveSensor) -> None:
        """Takes reference frames of the untouched sensor under the present lights."""
        self._told("rendering the untouched sensor")
        still, frames = replace(live.now(), deformation=live.sensor.rest, slid_mm=0.0), []
        for index in range(max(live.scene.references, 3)):
            time_s = index / still.frames_per_second
            state = with_passing(UNTOUCHED, live.sensor.rig, time_s=time_s, seed=still.seed)
            frames.append(live.develop(replace(still, index=index, time_s=time_s, state=state)))
        self.references = tuple(replace(each, truth=replace(each.truth, is_reference=True)) for each in frames)
        self._told("learning the untouched sensor")
        images = [frame.image for frame in frames]
        self.rest, self._profiles = np.mean(images, axis=0), fused_profiles(images)

    def _light(self, wish: Wish) -> None:
        live = self.live
        if wish.led_strength != self.now.led_strength:
            live.set_led_strength(*wish.led_strength)
            self.now = replace(self.now, led_strength=wish.led_strength)
        if wish.exposure_grey != self.now.exposure_grey:
            live.set_exposure_grey(wish.exposure_grey)
            self.now = replace(self.now, exposure_grey=wish.exposure_grey)
            self._learn(live)
        live.shine(on=wish.flashlight, x_mm=wish.light_x_mm)
        self.now = replace(self.now, flashlight=wish.flashlight, light_x_mm=wish.light_x_mm)

    def _move(self, wish: Wish) -> None:
        place = {"gap_mm": wish.gap_mm, "x_mm": wish.x_mm, "y_mm": wish.y_mm, "twist_deg": wish.twist_deg}
        if wish.has_object:
            self.live.move_to(**place)
        else:
            self.live.remove_object()
        self.now = replace(self.now, has_object=wish.has_object, **place)  # type: ignore[arg-type]

    def _sight(self, refusal: str | None, *, solve_s: float) -> Sight:
        live = self.live
        moved = live.deformation.displacements_mm
        indenter = live.sensor.indenter(live.state)
        return Sight(
            wish=self.now,
            nodes_mm=live.sensor.lattice.nodes_mm + moved,
            displacement_mm=np.linalg.norm(moved, axis=1),
            object_pose=indenter.pose if indenter is not None else None,
            force_n=live.truth.force_n,
            slip_share=live.slip_share,
            refusal=refusal,
            solve_s=solve_s,
        )


LOGGER = logging.getLogger(__name__)
READY = "ready"


class Worker:
    """Carries out wishes, one after the other, and shows each twice: the lattice first, then with the frame.

    Where something passes in the room, the next frame is shown when no wish comes in a frame's time.
    """

    def __init__(self, session: Session, show: Callable[[Sight], None], failed: Callable[[str], None]) -> None:
        self._session, self._show, self._failed = session, show, failed
        self._changed = threading.Condition()
        self._newest: Wish | None = None
        self._is_stopped = False
        self._thread = threading.Thread(target=self._work, name="magicsim-live", daemon=True)
        self._busy_since: float | None = None
        self._doing = READY

    def start(self) -> None:
        """Begins to work."""
        self._thread.start()

    def ask(self, wish: Wish) -> None:
        """Leaves a wish; one that waits is dropped for it. Never waits."""
        with self._changed:
            self._newest = wish
            self._changed.notify()

    def told(self, line: str) -> None:
        """Takes note of what is being done."""
        self._doing = line

    @property
    def busy(self) -> tuple[str, float] | None:
        """What is being done and for how long [s]; None when nothing is."""
        since = self._busy_since
        return None if since is None else (self._doing, time.monotonic() - since)

    @property
    def is_asked(self) -> bool:
        """Whether a newer wish waits."""
        return self._newest is not None

    def stop(self) -> None:
        """Ends after the wish that is being carried out, a minute at most; may be called again."""
        with self._changed:
            self._is_stopped = True
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join(60.0)

    def _next(self, timeout_s: float | None) -> Wish | None:
        """The newest wish, waiting for one; None where the worker is stopped, or nothing came in time."""
        with self._changed:
            self._changed.wait_for(lambda: self._newest is not None or self._is_stopped, timeout_s)
            newest, self._newest = self._newest, None
            return newest

    def _work(self) -> None:
        is_shown = False
        while not self._is_stopped:
            wish = self._next(self._session.pause_s if is_shown else None)
            if self._is_stopped:
                return
            wish, is_shown = wish or self._session.now, False
            self._busy_since = time.monotonic()
            try:
                self.told("solving")
                sight = self._session.go(wish)
                self._show(sight)
                self.told("rendering")
                self._show(self._session.look(sight))
                is_shown = True
            except MagicsimError as error:
                self._failed(str(error))
            except Exception as error:
                LOGGER.exception("the live window could not go on with a request")
                self._failed(f"{type(error).__name__}: {error}")
            finally:
                self._busy_since = None
                self.told(READY)
