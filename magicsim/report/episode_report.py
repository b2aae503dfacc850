"""What is made of an episode in its folder: verdicts, table, preview, page, and an MCAP file."""

import importlib
import logging
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType

from magicsim.camera.calibration import calibrate_camera
from magicsim.dataset.rows import frame_rows
from magicsim.errors import ConfigError, FrameError
from magicsim.judge.table import TABLE, write_table
from magicsim.judge.verdicts import COATED, PROFILES, Judgement, judge
from magicsim.report.page import render_report
from magicsim.report.preview import animate
from magicsim.simulation.episode import Episode

LOGGER = logging.getLogger(__name__)
REPORT, PREVIEW, MCAP = "report.html", "preview.webp", "episode.mcap"


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodeReport:
    """How an episode was judged, in a few figures; see `magicsim.simulation.main_job.RunSummary`."""

    seconds: float
    """Cost of judging [s]."""
    contact_accuracy: float | None
    proximity_accuracy: float | None
    at_rest: dict[str, dict[str, float]]
    not_judged: str | None
    page: str | None
    """Name of the HTML report in the folder, None where not asked for."""


def report_episode(folder: Path, episode: Episode, facts: Mapping[str, str]) -> EpisodeReport:
    """Judges an episode with every standard profile, and adds to its folder what its scene's output asks for."""
    scene, start = episode.scene, time.perf_counter()
    judgements, refused = judged(episode)
    seconds = time.perf_counter() - start
    write_table(folder / TABLE, episode, judgements)
    if scene.output.preview:
        verdicts = judgements[0].verdicts if judgements else ()
        animate(episode.scored, folder / PREVIEW, scene.frames_per_second, verdicts=verdicts)
    if scene.output.report:
        facts = dict(facts) | ({"Not judged": refused} if refused else {})
        (folder / REPORT).write_text(render_report(episode, judgements, facts), encoding="utf-8")
    if scene.output.mcap:
        write_mcap(folder / MCAP, episode)
    first = next((each for each in judgements if each.profile == PROFILES[0]), None)
    score = first.score if first else None
    return EpisodeReport(
        seconds=seconds,
        contact_accuracy=score.contact.accuracy if score else None,
        proximity_accuracy=score.proximity.accuracy if score and not scene.design.is_opaque else None,
        at_rest={name: asdict(each) for name, each in first.at_rest.items()} if first else {},
        not_judged=refused,
        page=REPORT if scene.output.report else None,
    )


def judged(episode: Episode) -> tuple[list[Judgement], str | None]:
    """Judgements of every standard profile, and what was not judged and why; None where all was.

    Detectors refuse a sensor that they cannot judge, such as one whose reference frames show no grid. That is no
    fault of the frames.
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
        raise ConfigError(f"output.mcap = true needs the package {error.name}: pip install 'magicsim[mcap]'") from None
