"""All episodes of an alignment into one folder; a run that was stopped goes on where it was."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from magicsim.arrays import Frame
from magicsim.folder.listing import sha256_of
from magicsim.light.variant import activate_variant
from magicsim.robot.gripper import Gripper
from magicsim.robot.live import MAX_SEED
from magicsim_experiments.learn.settings import PACKAGES, need_packages
from magicsim_experiments.task.alignment.episode import AlignmentFrame, AlignmentRecord, AngleReader, play
from magicsim_experiments.task.alignment.grip import AlignmentConfig, build_gripper, draw_grip, grip_scene
from magicsim_experiments.task.alignment.outcome import (
    READERS,
    AlignmentOutcome,
    AlignmentSummary,
    judge_episode,
    summarise,
)
from magicsim_experiments.task.growing import (
    EPISODES_TABLE,
    FRAMES_TABLE,
    RESULTS,
    Played,
    Progress,
    as_json,
    as_parquet,
    as_png,
    grow,
    resolved,
)
from magicsim_experiments.task.settings import load_item

COLORS = {"seen": "tab:blue", "unseen": "tab:orange"}
LIMIT = "tab:green"
AROUND_DEG = 5.0
"""Room beside the true angles, which hardly differ within an episode [degrees]."""


def draw_errors(
    outcomes: Sequence[AlignmentOutcome], rows: Sequence[AlignmentFrame], *, unseen: Sequence[str], within_deg: float
) -> bytes:
    """A PNG: above, each episode's error against time with the median of each group; below, errors of the readings.

    The limit is drawn as a band.
    """
    figure = Figure(figsize=(8, 6.5), layout="constrained")
    upper, lower = figure.subplots(2, 1, height_ratios=[3, 2])
    upper.axhspan(-within_deg, within_deg, color=LIMIT, alpha=0.15, linewidth=0)
    for group, color in COLORS.items():
        numbers = [each.episode for each in outcomes if (each.item in unseen) == (group == "unseen")]
        series = {number: [row for row in rows if row.episode == number] for number in numbers}
        drawn = [each for each in series.values() if each]
        for each in drawn:
            upper.plot([row.time_s for row in each], [row.error_deg for row in each], color=color, alpha=0.35, lw=1)
        if drawn:
            times = sorted({row.time_s for each in drawn for row in each})
            sizes = [[abs(row.error_deg) for each in drawn for row in each if row.time_s == time] for time in times]
            middle = [float(np.median(each)) for each in sizes]
            upper.plot(times, middle, "o-", color=color, ms=3, label=f"median size, {group} items ({len(drawn)})")
    upper.axhline(0, color="0.4", lw=0.8)
    upper.set_ylabel("axis to the vertical [degrees]")
    upper.legend()
    found = [np.array([getattr(row, column) - row.held_deg for row in rows]) for column in READERS.values()]
    truth = [row.held_deg for row in rows]
    for name, errors in zip(READERS, found, strict=True):
        lower.plot(truth, errors, "o", ms=3, alpha=0.5, label=name)
    lower.axhline(0, color="0.4", lw=0.8)
    if truth:
        lower.set_xlim(min(truth) - AROUND_DEG, max(truth) + AROUND_DEG)
    lower.set_ylabel("read less true [degrees]")
    lower.legend()
    for axes, title in ((upper, "time [s]"), (lower, "true angle in the grip [degrees]")):
        axes.set_xlabel(title)
        axes.grid(visible=True, alpha=0.3)
    return as_png(figure)


PLOT = "error.png"
NOISE = 37
"""Keeps the seeds of the frames' noise apart from others."""


class AlignmentPlayer:
    """Builds a gripper for an item and plays episodes with it; one gripper at a time is kept."""

    def __init__(self, config: AlignmentConfig, model: Path) -> None:
        """Checks everything that a run needs before it begins; see `run_alignment`."""
        need_packages(PACKAGES, "task alignment")
        self.reader = AngleReader(model)
        self.config = config.model_copy(update={"model_sha256": sha256_of(model)})
        self.items = {name: load_item(name) for name in config.items}
        self._scenes = {name: grip_scene(config, item, self.reader.reader.config) for name, item in self.items.items()}
        self._built: tuple[str, Gripper] | None = None

    def settings(self) -> dict[str, Any]:
        """What episodes depend on, with the content of every file; the model's is `model_sha256`."""
        return resolved(self.config, items=self.items, scenes=self._scenes, profile={})

    def order(self, episodes: int) -> list[int]:
        """Numbers of all episodes, those of an item one after the other."""
        return sorted(range(episodes), key=lambda number: (number % len(self.config.items), number))

    def play(
        self, episode: int, *, seen: Callable[[Frame, Frame, AlignmentFrame], None] | None = None
    ) -> tuple[AlignmentRecord, AlignmentOutcome]:
        """One episode, and what became of it."""
        config, grip = self.config, draw_grip(self.config, episode)
        seed = int(np.random.SeedSequence([config.seed, NOISE, episode]).generate_state(1)[0] % MAX_SEED)
        recorded = play(
            self._gripper(grip.item), self.reader, grip, self.items[grip.item], config, episode=episode, seed=seed,
            seen=seen,
        )  # fmt: skip
        return recorded, judge_episode(recorded, grip, episode=episode, within_deg=config.within_deg)

    def _gripper(self, item: str) -> Gripper:
        if self._built is None or self._built[0] != item:
            if self._built is not None:
                self._built[1].release()
            self._built = (item, build_gripper(self._scenes[item], self.config))
        return self._built[1]


def run_alignment(
    config: AlignmentConfig, model: Path, out: Path, *, episodes: int, resume: bool = False,
    progress: Progress | None = None, variant: Callable[[], str] = activate_variant,
) -> AlignmentSummary:  # fmt: skip
    """Plays episodes, or what an earlier run left of them, and writes their folder.

    Args:
        model: File `model.safetensors` of the study `alignment`.
        episodes: How many; a finished folder grows by more.
        resume: Whether to go on with the run in the folder.
        progress: Told how far it is: episodes done, all of them, a note.

    Raises:
        MagicsimError: The task cannot be played, or the folder is not ours or holds another task.
    """
    stage = AlignmentPlayer(config, model)

    def played(episode: int) -> Played:
        pairs: list[tuple[Frame, Frame]] = []
        recorded, outcome = stage.play(episode, seen=lambda upper, lower, _: pairs.append((upper, lower)))
        values = {"outcome": asdict(outcome), "rows": [asdict(row) for row in recorded.rows]}
        ends = {f"pictures/{episode:05d}.png": as_png(np.hstack([*pairs[0], *pairs[-1]]))} if pairs else {}
        return values, ends

    def concluded(played: Sequence[dict[str, Any]]) -> tuple[AlignmentSummary, dict[str, bytes]]:
        outcomes = [AlignmentOutcome(**each["outcome"]) for each in played]
        rows = [AlignmentFrame(**row) for each in played for row in each["rows"]]
        kept = stage.config
        summary = summarise(outcomes, rows, unseen=kept.unseen, within_deg=kept.within_deg, out=str(out))
        return summary, {
            FRAMES_TABLE: as_parquet([asdict(row) for row in rows]),
            EPISODES_TABLE: as_parquet([asdict(each) for each in outcomes]),
            PLOT: draw_errors(outcomes, rows, unseen=kept.unseen, within_deg=kept.within_deg),
            RESULTS: as_json(asdict(summary)),
        }

    return grow(
        out, stage.settings(), played, concluded, task="alignment", episodes=episodes, order=stage.order(episodes),
        resume=resume, progress=progress, variant=variant, packages=PACKAGES,
    )  # fmt: skip
