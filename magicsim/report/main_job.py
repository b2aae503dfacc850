"""The main job: simulate a scene, judge it, and leave a folder that explains itself."""

import importlib
import logging
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType

import cv2
import tomli_w

from magicsim.camera.calibration import calibrate_camera
from magicsim.dataset.rows import frame_rows
from magicsim.deform.lattice.structure import Lattice
from magicsim.errors import ConfigError, FrameError
from magicsim.folder import MARKER, SIGNATURE, result_folder
from magicsim.judge.table import TABLE, frame_file, write_lattice, write_table
from magicsim.judge.verdicts import COATED, PROFILES, Judgement, judge
from magicsim.light.variant import activate_variant
from magicsim.report.animation.preview import animate
from magicsim.report.page import render_report
from magicsim.scenes.scene import SceneConfig
from magicsim.simulation.episode import Episode
from magicsim.simulation.marker_truth import MARKERS, MarkerTracks, write_markers
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor
from magicsim.simulation.stream import Progress, simulate_with
from magicsim.waiting import Told, on_stderr, unheard, waiting

LOGGER = logging.getLogger(__name__)
REPORT = "report.html"
PREVIEW = "preview.webp"
LATTICE = "lattice.parquet"
MCAP = "episode.mcap"


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSummary:
    """What `magicsim demo` and `magicsim simulate` report."""

    frames: int
    """Frames written, references included."""
    seconds: float
    """Warm cost of solving, rendering and judging, without compilation and scene build [s]."""
    seconds_total: float
    """Everything [s]."""
    variant: str
    """Mitsuba variant that rendered."""
    estimator: str
    """Estimator that rendered."""
    contact_accuracy: float | None
    """Balanced accuracy of contact with the `calibrated` profile; None where a class has no frames."""
    proximity_accuracy: float | None
    """Balanced accuracy of proximity with the `calibrated` profile; None where a class has no frames, and behind an
    opaque coat."""
    at_rest: dict[str, dict[str, float]]
    """Mean and standard deviation of E, C and S over the reference frames, by `calibrated`; empty without."""
    not_judged: str | None
    """What was not judged, and why: profiles that gave no verdicts, proximity behind an opaque coat; None where all was
    judged, or where the scene has no reference frames."""
    report: str | None
    """Path of the HTML report, None where not asked for."""
    out: str
    """Folder of all results."""


def run_scene(scene: SceneConfig, out: Path, *, progress: Progress | None = None, told: Told = on_stderr) -> RunSummary:
    """Simulates a scene, judges it with every standard profile, and writes the episode's folder.

    Args:
        scene: What happens.
        out: Folder to write; an earlier result there is replaced at the very end.
        progress: Told after every frame.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        MagicsimError: Anything that keeps the episode from being valid, or the folder from being written.
    """
    start = time.perf_counter()
    with result_folder(out) as folder, waiting("running the scene", told if progress is None else unheard) as share:
        sensor = Sensor.for_scene(scene)
        episode = simulate_with(sensor, plan_scene(scene), progress=progress or share)
        before = time.perf_counter()
        judgements, refused = judged(episode)
        judging = time.perf_counter() - before
        facts = describe(scene, sensor.renderer.estimator) | ({"Not judged": refused} if refused else {})
        write_episode(folder, episode, judgements, sensor.printed, facts)
    first = next((each for each in judgements if each.profile == PROFILES[0]), None)
    score = first.score if first else None
    return RunSummary(
        frames=len(episode.frames),
        seconds=round(episode.seconds + judging, 3),
        seconds_total=round(time.perf_counter() - start, 3),
        variant=activate_variant(),
        estimator=sensor.renderer.estimator,
        contact_accuracy=score.contact.accuracy if score else None,
        proximity_accuracy=score.proximity.accuracy if score and not scene.design.is_opaque else None,
        at_rest={name: asdict(each) for name, each in first.at_rest.items()} if first else {},
        not_judged=refused,
        report=str(out / REPORT) if scene.output.report else None,
        out=str(out),
    )


def write_mcap(path: Path, episode: Episode) -> None:
    """Writes an episode as an MCAP file, see `magicsim.dataset.export.mcap`.

    Raises:
        ConfigError: The package for it is not installed.
    """
    mcap = load_mcap()
    scene, window = episode.scene, episode.scene.rig.camera.window
    rows = frame_rows(episode.frames, scene, calibrate_camera(scene.design, scene.rig))
    mcap.write_mcap_episode(path, rows, size=(window.columns, window.rows), about={"seed": str(scene.seed)})


def load_mcap() -> ModuleType:
    """The writer of MCAP files.

    Raises:
        ConfigError: The package for it is not installed.
    """
    try:
        return importlib.import_module("magicsim.dataset.export.mcap")
    except ImportError as error:
        msg = f"output.mcap = true needs the package {error.name}: pip install 'magicsim[mcap]'"
        raise ConfigError(msg) from None


def judged(episode: Episode) -> tuple[list[Judgement], str | None]:
    """What every standard profile makes of an episode.

    Detectors refuse a sensor that they cannot judge, such as one whose reference frames show no grid. That is no
    fault of the frames.

    Returns:
        The judgements, and which profiles refuse and why, and that nothing is near to what sees nothing; None where
        all is judged.
    """
    judgements, refusals = [], []
    if episode.references and episode.scene.design.is_opaque:
        refusals.append(COATED)
    for name in PROFILES if episode.references else ():
        try:
            judgements.append(judge(episode, name))
        except FrameError as error:
            refusals.append(f"profile '{name}': {error}")
            LOGGER.warning("no verdicts of profile '%s': %s; frames and truth are written without", name, error)
    return judgements, "; ".join(refusals) or None


def write_episode(
    folder: Path, episode: Episode, judgements: Sequence[Judgement], printed: Lattice, facts: Mapping[str, str]
) -> None:
    """Fills the folder of an episode: frames, table, and what its scene's output asks for.

    Args:
        folder: From `magicsim.folder.result_folder`.
        episode: What happened.
        judgements: From `judged`.
        printed: All planes of the design's lattice, which the displacements refer to.
        facts: Names and values at the head of the report.
    """
    scene = episode.scene
    write_frames(folder, episode)
    write_table(folder / TABLE, episode, judgements)
    if scene.output.displacements:
        write_lattice(folder / LATTICE, printed)
    tracks = MarkerTracks.of(scene.design, printed)
    if tracks is not None:
        write_markers(folder / MARKERS, tracks, scene.design, scene.rig)
    if scene.output.preview:
        verdicts = judgements[0].verdicts if judgements else ()
        animate(episode.scored, folder / PREVIEW, scene.frames_per_second, verdicts=verdicts)
    if scene.output.report:
        (folder / REPORT).write_text(render_report(episode, judgements, dict(facts)), encoding="utf-8")
    if scene.output.mcap:
        write_mcap(folder / MCAP, episode)
    (folder / MARKER).write_text(
        f"{SIGNATURE}\n{tomli_w.dumps(scene.model_dump(mode='json', exclude_none=True))}", encoding="utf-8"
    )


def write_frames(folder: Path, episode: Episode) -> None:
    """Writes every frame as a PNG below `frames/`."""
    (folder / "frames").mkdir()
    for frame in episode.frames:
        encoded = cv2.imencode(".png", cv2.cvtColor(frame.image, cv2.COLOR_RGB2BGR))[1]
        (folder / frame_file(frame.truth.index)).write_bytes(encoded.tobytes())


def describe(scene: SceneConfig, estimator: str) -> dict[str, str]:
    """Facts about a scene for its report."""
    design, render = scene.design, scene.render
    grid = f"cell {design.cell_mm:g} mm, wall {design.wall_mm:g} mm" if design.has_grid else "no grid"
    width, length = design.footprint_mm
    return {
        "Design": f"{width:g} x {length:g} x {design.height_mm:g} mm, skin {design.skin_mm:g} mm, {grid}",
        "Light": f"{estimator} ({activate_variant()}), {render.samples} samples a pixel, {render.particles} particles",
    }
