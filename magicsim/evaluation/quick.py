"""A quick evaluation: a fixed part of a suite, which for the suite `small` comes with the program.

What comes with it are the states of twelve objects before the camera, eight of each, an untouched one and three under
a flashlight. A state is an image of whole grey levels that it differs from the untouched one by, so that noise and
exposure are the camera's own and every machine sees the same pixels, whatever becomes of the simulator.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from magicsim.arrays import AnyArray
from magicsim.config.presets import preset_root
from magicsim.evaluation.footage import Footage, footage_of
from magicsim.evaluation.suite import QUICK, SuiteConfig
from magicsim.evaluation.take import Take, list_cases

REST_S = 10.0
"""Longest stream at rest of a quick evaluation [s]."""
MIDDLE = {"uint8": 128, "uint16": 32768}
"""Value of a pixel that does not differ from the untouched one, by the image's type."""
FINER = 8
"""Parts of a grey level in which the untouched state is kept."""
INDEX, UNTOUCHED, LIGHT = "index.json", "untouched.png", "light.png"


def quick_suite(suite: SuiteConfig) -> tuple[SuiteConfig, list[str]]:
    """A suite's standard condition alone, and what that leaves out."""
    blocks = [
        block.model_copy(update={"lights": block.lights[:1], "seeds": block.seeds[:1], "places": ()})
        for block in suite.episodes
        if block.lights[0] == suite.episodes[0].lights[0]
    ]
    rest = min(suite.rest_s, REST_S)
    quick = suite.model_copy(
        update={"episodes": tuple(blocks), "noises": suite.noises[:1], "rest_s": rest, "recordings": suite.recordings}
    )
    kept = {case.name for case in list_cases(quick)}
    gone = [case.name for case in list_cases(suite) if case.name not in kept]
    left_out = [f"take {name}" for name in gone]
    left_out += [f"noise {noise.name}" for noise in suite.noises[1:]]
    if rest < suite.rest_s:
        left_out.append(f"{suite.rest_s - rest:g} of {suite.rest_s:g} s at rest")
    return quick, left_out


@dataclass(frozen=True, slots=True, kw_only=True)
class QuickSet:
    """Takes that come with the program."""

    folder: Path
    grey: float
    """Radiance of a grey level."""
    state: tuple[int, ...]
    """What each frame shows: the untouched state (0), one of the object's, or one of the flashlight's after those."""
    flashlight: tuple[bool, ...]
    takes: dict[str, dict[str, Any]]
    """By name: `file`, and `gap_mm` (null without an object) and `force_n` of each frame."""
    made_by: dict[str, str]
    """See `magicsim.config.program.versions`."""

    def take(self, name: str, references: int) -> Take:
        """One take, with so many references before its frames."""
        entry, untouched = self.takes[name], _image(self.folder / UNTOUCHED).astype(np.float32) * (self.grey / FINER)
        images = (_image(self.folder / file) for file in (entry["file"], LIGHT))
        changes = [each.astype(np.float32) - MIDDLE[each.dtype.name] for each in images]
        states = untouched + self.grey * np.concatenate(changes).reshape(-1, *untouched.shape)
        count = references + len(self.state)
        at_rest = [np.nan] * references
        return Take(
            radiance=np.concatenate([untouched[None], states]).astype(np.float32), room=np.zeros(0, np.float32),
            state=np.array([0] * references + list(self.state), np.int32), is_reference=np.arange(count) < references,
            gap_mm=np.array([*at_rest, *(np.nan if each is None else each for each in entry["gap_mm"])], np.float64),
            force_n=np.array([0.0] * references + entry["force_n"], np.float64),
            flashlight=np.array([False] * references + list(self.flashlight), bool),
        )  # fmt: skip


def load_quick_set(folder: Path | None = None) -> QuickSet:
    """The set that comes with the program, or that of a folder."""
    folder = folder or preset_root() / "detectors" / QUICK
    return QuickSet(folder=folder, **json.loads((folder / INDEX).read_text(encoding="utf-8")))


def shipped_films(suite: SuiteConfig) -> list[list[Footage]]:
    """Footage of a quick suite's takes that come with the program."""
    shipped, cases = load_quick_set(), {each.name: each for each in list_cases(suite)}
    return [footage_of(cases[name], shipped.take(name, suite.references), suite) for name in shipped.takes]


def _image(path: Path) -> AnyArray:
    return np.asarray(cv2.imread(str(path), cv2.IMREAD_UNCHANGED))
