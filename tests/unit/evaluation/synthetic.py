"""A made-up sensor whose takes need no renderer: cached episodes, small and with every class in them."""

import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.verdict import Contact, Proximity
from magicsim.evaluation.suite import SuiteConfig, load_suite
from magicsim.evaluation.take import Case, Take, list_cases, take_key, write_take
from magicsim.judge.tally import EpisodeLabels, EpisodeTag, JudgedEpisode
from magicsim.scenes.timeline import FrameState, timeline

ROWS, COLUMNS = 48, 36
OBJECTS = 8
PROFILE = DetectorProfile(
    reference_count=6, grid_blur_px=3, tau_e=1.0, tau_c=0.8, tau_b=60, tau_g=0.8, polarity="bright"
)
"""Of the built-in detectors, as it suits this sensor."""
SUITE = """
schema_version = 1
design = "uniform-block"
rig = "digit-rgb"
references = 6
resamples = 99

[[noises]]
name = "rig"

[[noises]]
name = "high"
full_well_e = 60000.0

[[lights]]
name = "dark"

[[paths]]
name = "story"
frames = [
    {{ frame = 0 }},
    {{ frame = 3, gap_mm = 30.0 }},
    {{ frame = 9, gap_mm = 3.0 }},
    {{ frame = 12, gap_mm = 0.1 }},
    {{ frame = 13, gap_mm = -0.2 }},
    {{ frame = 14, gap_mm = -0.3 }},
    {{ frame = 17, press = 1.0 }},
    {{ frame = 18, gap_mm = 4.0 }},
    {{ frame = 19 }},
    {{ frame = 21, flashlight = true, light_x_mm = -3.0 }},
    {{ frame = 24, flashlight = true, light_x_mm = 3.0 }},
]

{objects}
[[episodes]]
objects = [{names}]
paths = ["story"]
lights = ["dark"]
"""


def write_suite(folder: Path, *, objects: int = OBJECTS) -> Path:
    """A suite file of some balls, every other one of the calibration."""
    names = [f"ball-{number}" for number in range(objects)]
    tables = "".join(
        f'[[objects]]\nname = "{name}"\nobject = "sphere:radius_mm={3 + number}"\n'
        f'role = "{("training", "held_out")[number % 2]}"\npress_mm = 1.0\n\n'
        for number, name in enumerate(names)
    )
    path = folder / "tiny.toml"
    path.write_text(SUITE.format(objects=tables, names=", ".join(f'"{name}"' for name in names)))
    return path


def fill_cache(suite: SuiteConfig, cache: Path) -> None:
    """Writes a made-up take for every case of a suite, as if it had been simulated."""
    for case in list_cases(suite):
        write_take(cache / f"{take_key(case.scene)}.npz", make_take(case))


def make_suite(folder: Path, *, objects: int = OBJECTS, **changes: object) -> tuple[SuiteConfig, Path]:
    """A suite and its filled cache."""
    path = write_suite(folder, objects=objects)
    suite = load_suite(path, [f"{key}={value}" for key, value in changes.items()])
    fill_cache(suite, folder / "takes")
    return suite, folder / "takes"


def make_take(case: Case) -> Take:
    """States of a made-up sensor: bright cells between dark lines."""
    states = [*[None] * case.scene.references, *timeline(case.scene)]
    gaps = np.array([np.nan if each is None or each.gap_mm is None else each.gap_mm for each in states])
    return Take(
        radiance=np.stack([_grid(0.0), *(_radiance(each, case.name) for each in states if each is not None)]).astype(
            np.float32
        ),
        room=np.zeros(0, np.float32),
        state=np.array([*[0] * case.scene.references, *range(1, 1 + len(states) - case.scene.references)], np.int32),
        is_reference=np.array([each is None for each in states]),
        gap_mm=gaps,
        force_n=np.where(gaps < 0, 4 * np.maximum(0, -gaps) ** 1.5, 0.0),
        flashlight=np.array([each is not None and each.flashlight for each in states]),
    )


def _grid(width_px: float) -> np.ndarray:
    """Bright cells between dark lines of a width with soft edges; red light from the left, blue from the right."""
    rows, columns = np.indices((ROWS, COLUMNS))
    edge = np.minimum(3 - np.abs(rows % 6 - 3), 3 - np.abs(columns % 6 - 3))
    level = 0.03 + 0.47 * np.clip(edge - width_px, 0, 1)
    across = columns / COLUMNS
    return level[..., None] * np.stack([1.12 - 0.24 * across, np.ones_like(level), 0.88 + 0.24 * across], axis=2)


def _radiance(state: FrameState, name: str) -> np.ndarray:
    gap_mm = np.nan if state.gap_mm is None else state.gap_mm
    return seen_state(gap_mm, name, is_lit=state.flashlight, light_x_mm=state.light_x_mm)


def seen_state(gap_mm: float, name: str, *, is_lit: bool, light_x_mm: float = 0.0) -> np.ndarray:
    """Near objects brighten each colour elsewhere, a press thickens the lines, light brightens all alike."""
    strength = np.random.default_rng(zlib.crc32(name.encode())).uniform(0.8, 1.2)
    rows, columns = np.indices((ROWS, COLUMNS)) / ROWS
    image = _grid(1.4 * max(0.0, -np.nan_to_num(gap_mm)) * strength)
    if not np.isnan(gap_mm):
        near = 0.6 * strength / (1 + max(0.0, gap_mm)) * image
        image = image + near * np.stack([rows, np.abs(columns - 0.4), 1 - rows], axis=2)
    if is_lit:
        image += (0.5 * np.exp(-8 * ((columns - 0.4 - light_x_mm / 20) ** 2 + (rows - 0.5) ** 2)))[..., None]
    return image


def judged(
    name: str,
    *,
    miss: Sequence[int] = (),
    seed: int = 0,
    object: str | None = None,
    sharpness: float = 4.0,
) -> JudgedEpisode:
    """An episode of 4 Clear, 6 Near, 4 Contact and 4 Light frames with right verdicts, but for those at `miss`."""
    gap = np.array([np.nan] * 4 + [3.0, 2.5, 2.0, 1.0, 0.5, 0.1] + [-0.3, -0.5, -0.8, -1.0] + [np.nan] * 4)
    force = np.where(gap < 0, 1.0, 0.0)
    labels = EpisodeLabels.of(gap, force, np.array([False] * 14 + [True] * 4))
    near = [Proximity.NORMAL] * 4 + [Proximity.APPROACHING] * 6 + [Proximity.APPROACHING] * 4 + [Proximity.NOISE] * 4
    touch = [Contact.UNTOUCHED] * 10 + [Contact.TOUCHED] * 4 + [Contact.UNKNOWN] * 4
    random = np.random.default_rng([seed, zlib.crc32(name.encode())])
    approach = sharpness * np.array([one is Proximity.APPROACHING for one in near]) + random.standard_normal(18)
    touched = sharpness * np.array([one is Contact.TOUCHED for one in touch]) + random.standard_normal(18)
    for place in miss:
        near[place] = Proximity.NORMAL if near[place] is not Proximity.NORMAL else Proximity.APPROACHING
        touch[place] = Contact.UNTOUCHED if touch[place] is Contact.TOUCHED else Contact.TOUCHED
    return JudgedEpisode(
        tag=EpisodeTag(take=name, object=object or name, role="held_out", path="story", light="dark", noise="rig"),
        labels=labels,
        proximity=tuple(map(str, near)),
        contact=tuple(map(str, touch)),
        approach=approach,
        touch=touched,
    )
