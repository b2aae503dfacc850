"""The main job: simulate a scene, and leave a folder of frames and truth that is judged and explains itself."""

import importlib
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import pyarrow as pa
import pyarrow.parquet as pq
import tomli_w

from magicsim.arrays import Array
from magicsim.camera.projection import project_px
from magicsim.deform.lattice.structure import Lattice
from magicsim.folder import MARKER, SIGNATURE, result_folder
from magicsim.light.variant import activate_variant
from magicsim.scenes.scene import SceneConfig
from magicsim.simulation.episode import Episode, frame_file
from magicsim.simulation.meshes import marker_map
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor
from magicsim.simulation.stream import Progress, simulate_with
from magicsim.waiting import Told, on_stderr, unheard, waiting

LATTICE, MARKERS = "lattice.parquet", "markers.parquet"
"""Tables of undisplaced nodes and markers in a folder of results."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSummary:
    """Summary of a simulation, as `magicsim simulate` prints it."""

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
        estimator = sensor.renderer.estimator
        write_episode(folder, episode, sensor.printed)
        judging = importlib.import_module("magicsim.report.episode_report")  # it stands above the simulation
        seconds, judged = judging.report_episode(folder, episode, describe(scene, estimator))
    return RunSummary(
        frames=len(episode.frames), seconds=round(episode.seconds + seconds, 3),
        seconds_total=round(time.perf_counter() - start, 3), variant=activate_variant(), estimator=estimator, **judged,
        report=str(out / judging.REPORT) if scene.output.report else None, out=str(out),
    )  # fmt: skip


def write_episode(folder: Path, episode: Episode, printed: Lattice) -> None:
    """Fills the folder of an episode with frames, rest positions of what the truth refers to, and the scene.

    The truth's displacements refer to all planes of the lattice as it is `printed`.
    """
    scene = episode.scene
    write_frames(folder, episode)
    if scene.output.displacements:
        write_places(folder / LATTICE, printed.nodes_mm, {})
    markers = marker_map(scene.design, printed)
    if markers is not None:  # one row each, in the order of every frame's lists
        pixels = project_px(markers.points_mm, scene.design, scene.rig.lens, scene.rig.camera)
        write_places(folder / MARKERS, markers.points_mm, {"column_px": pixels[:, 0], "row_px": pixels[:, 1]})
    (folder / MARKER).write_text(
        f"{SIGNATURE}\n{tomli_w.dumps(scene.model_dump(mode='json', exclude_none=True))}", encoding="utf-8"
    )


def write_frames(folder: Path, episode: Episode) -> None:
    """Writes every frame as a PNG below `frames/`."""
    (folder / "frames").mkdir()
    for frame in episode.frames:
        encoded = cv2.imencode(".png", cv2.cvtColor(frame.image, cv2.COLOR_RGB2BGR))[1]
        (folder / frame_file(frame.truth.index)).write_bytes(encoded.tobytes())


def write_places(path: Path, places_mm: Array, more: dict[str, Array]) -> None:
    """Writes rest positions, shape (places, 3) [mm], and further columns to a Parquet file, one row each."""
    columns = {f"{axis}_mm": places_mm[:, number] for number, axis in enumerate("xyz")}
    pq.write_table(pa.table(columns | more), path, compression="zstd")


def describe(scene: SceneConfig, estimator: str) -> dict[str, str]:
    """Facts about a run for its report, beside those of the scene."""
    work = f"{scene.render.samples} samples a pixel, {scene.render.particles} particles"
    return {"Light": f"{estimator} ({activate_variant()}), {work}"}
