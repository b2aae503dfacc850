"""Frames of the window, kept until they are written as an episode's folder."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from magicsim.deform.lattice.structure import Lattice
from magicsim.folder import result_folder
from magicsim.live.sight import Wish
from magicsim.report.episode_report import report_episode
from magicsim.robot.darkroom import FULL
from magicsim.scenes.scene import Keyframe, SceneConfig
from magicsim.simulation.episode import Episode, SimulatedFrame
from magicsim.simulation.main_job import describe, write_episode

LONGEST = 3000
"""Most frames of a recording: they are kept in memory until it ends."""


class Recording:
    """The frames of one recording, in order; lights, exposure and design stay as they are meanwhile."""

    def __init__(self, scene: SceneConfig, references: Sequence[SimulatedFrame], printed: Lattice, begun: Wish) -> None:
        self.scene, self.references, self.printed, self.begun = scene, tuple(references), printed, begun
        self._frames: list[SimulatedFrame] = []

    def __len__(self) -> int:
        return len(self._frames)

    @property
    def is_full(self) -> bool:
        """Whether no more frames are taken."""
        return len(self._frames) >= LONGEST

    def add(self, frame: SimulatedFrame) -> None:
        """Takes a frame; none beyond `LONGEST`."""
        if not self.is_full:
            self._frames.append(frame)

    def episode(self) -> Episode:
        """The episode: references first, frames numbered on from them, its scene's keyframes where the object was."""
        rate, taken = self.scene.frames_per_second, tuple(self._frames)
        frames = [
            replace(frame, truth=replace(frame.truth, index=index, time_s=index / rate))
            for index, frame in enumerate((*self.references, *taken))
        ]
        fields = [name for name in Keyframe.model_fields if name != "frame"]
        keyframes = tuple(
            Keyframe(frame=number, **{name: getattr(each.truth.state, name) for name in fields})
            for number, each in enumerate(taken)
        )
        scene = self.scene.model_copy(update={"keyframes": keyframes, "references": len(self.references)})
        return Episode(scene=scene, frames=tuple(frames))

    def write(self, folder: Path, *, estimator: str) -> None:
        """Writes the episode as `magicsim simulate` does, into a new folder."""
        episode = self.episode()
        facts = describe(episode.scene, estimator) | {"Recorded": "in the live window, a frame for each motion"}
        if self.begun.led_strength != FULL:
            facts["LEDs"] = "strength {:g}, {:g}, {:g} (red, green, blue)".format(*self.begun.led_strength)
        with result_folder(folder, is_listed=False) as partial:
            write_episode(partial, episode, self.printed)
            report_episode(partial, episode, facts)


def recording_name(number: int) -> str:
    """Name of a recording's folder: when it was written, and a number of its own."""
    return f"live-{datetime.now(UTC):%Y%m%d-%H%M%S}-{number}"
