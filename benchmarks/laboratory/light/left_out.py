"""Rules that leave work out: seconds with and without each, on the same state, and the change of the result.

A rule is *exact* where the result must be the same to the last bit, *bounded* where it may differ by a stated bound,
and *statistical* where another way to the same image is taken. Beside its difference stands what both ways' noise
explains; it leaves out the fixed pattern of camera samples, of which each way has its own (`path_starts`).
"""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from laboratory.benchmark import logged, machine
from magicsim.camera.stream import CameraStream, Instant
from magicsim.deform.indentation.press import compile_kernels
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import UNKNOWN_ORIGIN, timeline
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor
from magicsim.simulation.stream import RenderedState, Shot, simulate_with

Array = npt.NDArray[np.float64]
Run = Callable[[], Array]
Result = Literal["exact", "statistical", "bounded"]
REPEATS, QUICK_REPEATS = 5, 2
SMALL = (
    "rig.camera.columns=48", "rig.camera.rows=64", "render.samples=2", "render.particles=8000",
    "render.anchor_samples=4", "render.anchor_particles=60000",
)  # fmt: skip
HELD = "[{frame=0}, {frame=1, gap_mm=2.0}, {frame=2, gap_mm=-0.5}, {frame=5, gap_mm=-0.5}, {frame=6, gap_mm=2.0}]"
"""An object that comes, is held for four frames and goes back to where it was."""
OTHER_SEED = 1000
LIGHT_TOUCH_MM, LIGHT_PASS_MM = 0.02, 0.1
"""Depth of a touch that hardly moves anything, and of one that can change little light [mm]."""
DARK = "rig=digit-rgb"
"""A room without light: in one that is lit, a lamp and what is far off still cover what is behind them."""
FAR_MM = 1500.0
"""Distance of an object that is too far to be seen [mm]."""
MIDDLE = 4
"""A region of interest is the middle of the image, a quarter of its columns and rows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOutRow:
    """One rule."""

    rule: str
    result: Result
    """Promise of the rule; `bounded`: to a stated bound."""
    seconds_full: float
    """Median, everything done."""
    seconds: float
    """Median, with the rule."""
    saved: float
    """Share of the time."""
    difference: float
    """Root mean square over the result, in units of its mean; 0 is the same to the last bit."""
    noise: float | None
    """Statistical rules: what the difference would be by chance, from the spread of both ways over seeds, in the same
    units."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """One rule as two ways to the same result."""

    name: str
    result: Result
    full: Run
    lean: Run
    again: tuple[Run, Run] | None = None
    """Both ways with other random numbers."""


def run_left_out(*, quick: bool = False) -> dict[str, Any]:
    """All rules.

    Args:
        quick: Small images, fewer repeats.
    """
    settings = SMALL if quick else ()
    rows = logged(measured(make(settings), QUICK_REPEATS if quick else REPEATS) for make in RULES)
    return {"kind": "left-out", "quick": quick, "results": [asdict(row) for row in rows], "machine": machine()}


def measured(rule: Rule, repeats: int) -> LeftOutRow:
    """Both ways of a rule, timed and compared."""
    seconds: dict[str, list[float]] = {"full": [], "lean": []}
    rule.full(), rule.lean()  # compiles
    for _ in range(repeats):
        start = time.perf_counter()
        full = rule.full()
        middle = time.perf_counter()
        lean = rule.lean()
        seconds["full"].append(middle - start)
        seconds["lean"].append(time.perf_counter() - middle)
    size = max(float(np.abs(full).mean()), 1e-300)
    noise = None
    if rule.again is not None:
        spreads = [_rms(one - again()) / np.sqrt(2) for one, again in zip((full, lean), rule.again, strict=True)]
        noise = float(np.hypot(*spreads)) / size
    whole, with_rule = (float(np.median(seconds[each])) for each in ("full", "lean"))
    return LeftOutRow(
        rule=rule.name,
        result=rule.result,
        seconds_full=whole,
        seconds=with_rule,
        saved=1 - with_rule / whole,
        difference=_rms(full - lean) / size,
        noise=noise,
    )


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))


def _repeated_states(settings: tuple[str, ...]) -> Rule:
    scene = load_scene("near", [f"keyframes={HELD}", "references=2", *settings])
    sensor = Sensor.for_scene(scene)

    def run(*, leave_out: bool) -> Array:
        episode = simulate_with(sensor, plan_scene(scene, leave_out=leave_out))
        return np.array([frame.image for frame in episode.frames], float)

    return Rule(
        name="frames that look as an earlier one", result="exact", full=lambda: run(leave_out=False),
        lean=lambda: run(leave_out=True),
    )  # fmt: skip


def far_field(settings: tuple[str, ...]) -> Rule:
    """The lattice that grows coarser away from the contact, against one that is fine everywhere."""
    scene = load_scene("pressed", settings)
    graded, whole = (
        Sensor.for_scene(scene),
        Sensor.for_scene(load_scene("pressed", [*settings, "design.lattice.growth=1"])),
    )
    state = timeline(scene)[0]
    compile_kernels()
    return Rule(
        name="fine lattice away from the contact", result="bounded",
        full=lambda: whole.deform(state, whole.rest).force_n[2:],
        lean=lambda: graded.deform(state, graded.rest).force_n[2:],
    )  # fmt: skip


def recorded(state: str) -> Callable[[tuple[str, ...]], Rule]:
    """Paths that the untouched block has recorded, in a preset scene's first state."""

    def make(settings: tuple[str, ...]) -> Rule:
        scene = load_scene(state, settings)
        other = load_scene(state, [*settings, f"render.anchor_seed={OTHER_SEED}"], seed=OTHER_SEED)
        return Rule(
            name=f"paths within the untouched block ({state})", result="statistical", full=_image(scene, whole=True),
            lean=_image(scene), again=(_image(other, whole=True), _image(other)),
        )  # fmt: skip

    return make


def out_of_reach(settings: tuple[str, ...]) -> Rule:
    """An object too far away to be seen."""
    scene = load_scene("near", [DARK, *settings, f"keyframes=[{{frame=0, gap_mm={FAR_MM}}}]"])
    return Rule(
        name=f"an object {FAR_MM / 1000:g} m away", result="bounded", full=_image(scene, far=True), lean=_image(scene)
    )


def still_meshes(settings: tuple[str, ...]) -> Rule:
    """Vertices that are not moved anew where another mesh moves."""
    scene = load_scene("near", [*settings, "keyframes=[{frame=0, gap_mm=1.2}, {frame=1, gap_mm=1.0}]"])
    sensor = Sensor.for_scene(scene)
    sensor.renderer.leaves_out_unmoved = False
    body, infill = sensor.elastomer.body, sensor.elastomer.infill

    def run(*, anew: bool) -> Array:
        views = [sensor.view(state, sensor.rest) for state in timeline(scene)]
        if anew:
            cells = infill.vertices.copy() if infill is not None else None
            views = [replace(view, body=body.vertices.copy(), infill=cells) for view in views]
        return np.array([sensor.renderer.radiance(view) for view in views], float)

    return Rule(
        name="vertices of meshes that did not move, beside one that did", result="exact", full=lambda: run(anew=True),
        lean=lambda: run(anew=False),
    )  # fmt: skip


def _hardly_moved(field: str, what: str) -> Callable[[tuple[str, ...]], Rule]:
    """Rule of light touches, left out up to a bound, a field of the scene's render settings [mm]."""

    def make(settings: tuple[str, ...]) -> Rule:
        press = f"keyframes=[{{frame=0, gap_mm=-{LIGHT_TOUCH_MM}}}]"
        lean, full = (load_scene("pressed", [*settings, press, *more]) for more in ((), (f"render.{field}=0",)))
        other = load_scene(
            "pressed", [*settings, press, f"render.{field}=0", f"render.anchor_seed={OTHER_SEED}"], seed=OTHER_SEED
        )
        bound = getattr(lean.render, field)
        return Rule(
            name=f"{what} {bound:g} mm, pressed {LIGHT_TOUCH_MM} mm", result="bounded",
            full=_image(full), lean=_image(lean), again=(_image(other), _image(other)),
        )  # fmt: skip

    return make


def _light_of_touches(settings: tuple[str, ...]) -> Rule:
    """A ball that is pressed about as deep as a touch may be whose light pass is left out."""
    press, traced = f"keyframes=[{{frame=0, gap_mm=-{LIGHT_PASS_MM}}}]", "render.light_change=0"
    lean, full = (load_scene("pressed", [*settings, press, *more]) for more in ((), (traced,)))
    other = load_scene("pressed", [*settings, press, traced, f"render.anchor_seed={OTHER_SEED}"], seed=OTHER_SEED)
    change = f"{100 * lean.render.light_change:g} %"
    return Rule(
        name=f"light pass of a touch of {LIGHT_PASS_MM} mm, below {change} of expected change", result="bounded",
        full=_image(full), lean=_image(lean), again=(_image(other), _image(other)),
    )  # fmt: skip


def _image(scene: SceneConfig, *, whole: bool = False, far: bool = False) -> Run:
    """Renders the scene's first state, its meshes moved anew; `whole` without recorded paths, `far` at any distance."""
    sensor, state = Sensor.for_scene(scene), timeline(scene)[0]
    deformation = sensor.deform(state, sensor.rest) if state.can_touch else sensor.rest
    sensor.renderer.leaves_out_unmoved, sensor.renderer.leaves_out_far = not whole, not far
    sensor.renderer.prepare(sensor.view(state, deformation))
    return lambda: sensor.radiance(state, deformation).astype(np.float64)


def _nothing_scatters(settings: tuple[str, ...]) -> Rule:
    bare = ("render.anchor_samples=0", "design.materials.body.sigma_s_per_mm=0")
    clear, barely = (
        load_scene("flashlight", [*settings, *bare, f"design.materials.infill.sigma_s_per_mm={sigma}"])
        for sigma in ("0", "1e-30")
    )
    return Rule(name="light pass where nothing scatters", result="exact", full=_image(barely), lean=_image(clear))


def _region(settings: tuple[str, ...]) -> Rule:
    scene = load_scene("pressed", settings)
    camera = scene.rig.camera
    columns, rows = camera.columns // MIDDLE, camera.rows // MIDDLE
    left, top = (camera.columns - columns) // 2, (camera.rows - rows) // 2
    cropped = load_scene("pressed", [*settings, f"rig.camera.region_px=[{left},{top},{columns},{rows}]"])
    whole = _image(scene)
    return Rule(
        name=f"pixels outside of a region of 1/{MIDDLE**2}", result="exact",
        full=lambda: whole()[top : top + rows, left : left + columns], lean=_image(cropped),
    )  # fmt: skip


def dark_flashlight(settings: tuple[str, ...]) -> Rule:
    """A lamp that gives no light."""
    whole = (DARK, "render.anchor_samples=0")
    off = load_scene("rest", [*settings, *whole])
    lamp = load_scene("flashlight", [*settings, *whole, "rig.flashlight.radiance=[0,0,0]"])
    return Rule(name="a flashlight that is off", result="exact", full=_image(lamp), lean=_image(off))


def bare_outputs(settings: tuple[str, ...]) -> Rule:
    """A mask and displacements that nobody asked for."""
    scene = load_scene("pressed", ["references=0", *settings])
    bare = scene.model_copy(
        update={"output": scene.output.model_copy(update={"contact_mask": False, "displacements": False})}
    )
    sensor = Sensor.for_scene(scene)
    state = timeline(scene)[0]
    deformation = sensor.deform(state, sensor.rest)
    radiance = sensor.radiance(state, deformation)
    whole, lean = (
        Shot.of(sensor, asked.output, CameraStream.of(asked.rig.camera, radiance, asked.lit)) for asked in (scene, bare)
    )
    first = Instant(seed=0, index=0, time_s=0.0, frames_per_second=scene.frames_per_second)
    seen = RenderedState(
        state=state, deformation=deformation, radiance=radiance, origin=UNKNOWN_ORIGIN, is_reference=False
    )

    def run(shot: Shot) -> Array:
        memory = shot.camera.begin(scene.frames_per_second)
        frame, _ = shot.take(seen, memory, first)
        return frame.image.astype(float)

    return Rule(name="outputs not asked for", result="exact", full=lambda: run(whole), lean=lambda: run(lean))


RULES: tuple[Callable[[tuple[str, ...]], Rule], ...] = (
    _repeated_states, far_field, _nothing_scatters, recorded("near"),
    recorded("flashlight"), out_of_reach, _hardly_moved("still_mm", "displacements below"),
    _hardly_moved("reuse_mm", "camera paths past what moved by less than"), _light_of_touches,
    _region, bare_outputs,
)  # fmt: skip
