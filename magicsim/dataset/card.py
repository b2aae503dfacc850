"""A dataset describes itself: the card `README.md`, whose header `datasets` reads, and how far off its forces may be.

Errors of force are shares of it, by cause. They say how a real sensor of the same design may differ from the label,
beyond what a recipe's tolerances draw. Labels are quasi-static: they hold for the stiffness at the time of a hardness
reading, 1 s after contact; with `contact.rate_dependent` they follow the relaxation of the body. A cause whose size
nobody knows has None, and so has the total. Of images it states the camera's noise and the renderer's error.
"""

import json
from collections.abc import Iterable, Sequence

import numpy as np

from magicsim.dataset.assembly import Layout
from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.dataset.shard import Column
from magicsim.scenes.timeline import TierError

Share = tuple[float, float]
"""Least and largest relative difference from the label."""
LATTICE: Share = (-0.06, 0.08)
"""Node spacing of a printed cell below round objects, whose labels are 7 % too low to 6 % too high, and finer ones at
the edges of punches and boxes (docs/physics/mechanics.md, "How far off it is")."""
EDGES: Share = (-0.16, 0.16)
"""Node spacing below edges and textures that get no planes of their own."""
FLAT_KINDS = frozenset({"cone", "dots", "lines", "mesh"})
"""Objects with such edges or textures."""
TIME: Share = (-0.29, 0.6)
"""Relaxation of Agilus30 from 0.1 to 60 s of contact; the stiffness is that after 1 s (docs/validation.md)."""
TIME_OF_READING: Share = (0.0, 1.6)
"""What a relaxing body leaves of it: its times are scaled to a hardness reading 1 s after contact; for one after 15 s
the stiffness is 2.6 times as large after 0.1 s and 1.2 times after 60 s (docs/validation.md)."""
MODULI: Share = (-0.25, 0.1)
"""What two fitted stiffnesses leave of seven other hardness readings (docs/validation.md): most are read too hard."""
CONTROL: Share = (-0.09, 0.0)
"""What `contact.quality = "control"` adds: labels of a ball are 3 to 9 % too high (docs/benchmarks/tiers.json)."""
LEAST_HEIGHT_MM = 5.0
"""Least height for which that was found out; thinner blocks are read too hard by an unknown part."""

TOUCH_ERROR, NEAR_ERROR, TOUCH_SAMPLES = 0.88, 0.2, 8
"""Error of the change of the image by a ball 1 mm deep in the default sensor, and by one 1 mm before it, root mean
square over all of it [grey levels], with that many samples a pixel (docs/benchmarks/frame-error.json)."""


def camera_noise(recipe: Recipe) -> float:
    """Noise of the rig's camera at its exposure's mean [grey levels, rms]."""
    camera = recipe.rig.camera
    signal = (camera.exposure_grey / 255) ** camera.gamma
    noise = np.sqrt(signal * camera.full_well_e + camera.read_noise_e**2) / camera.full_well_e
    slope = 255 / camera.gamma * signal ** (1 / camera.gamma - 1)
    return float(slope * noise)


def image_sentence(recipe: Recipe) -> str:
    """For the dataset card."""
    noise = f"`image` has the camera's noise, {camera_noise(recipe):.2f} grey levels rms in the mean, and the"
    if recipe.render.tier == "fast":
        return f"{noise} fast tier's error, which the next lines state (magicsim's `docs/results.md`)."
    return (
        f"{noise} renderer's error: of what a ball 1 mm deep changes of the default sensor's image {TOUCH_ERROR:g} "
        f"grey levels rms with {TOUCH_SAMPLES} samples a pixel, of what one 1 mm in front of it changes {NEAR_ERROR:g} "
        f"(magicsim's `docs/results.md`); these images have {recipe.render.samples} samples, and other sensors and "
        "touches were not measured."
    )


def force_error(recipe: Recipe) -> dict[str, Share | None]:
    """Shares by cause, and their root of squares as `total`; None where the error is not known."""
    kinds = {each.kind for each in recipe.objects}
    parts = {
        "lattice": EDGES if kinds & FLAT_KINDS else LATTICE,
        "time": TIME_OF_READING if recipe.contact.rate_dependent else TIME,
    }
    if recipe.contact.quality == "control":
        parts["quality"] = CONTROL
    if recipe.design.height_mm < LEAST_HEIGHT_MM:
        return {**parts, "moduli": None, "total": None}
    parts["moduli"] = MODULI
    low, high = (round(float(sum(part[side] ** 2 for part in parts.values()) ** 0.5), 3) for side in (0, 1))
    return {**parts, "total": (-low, high)}


def as_sentence(recipe: Recipe) -> str:
    """For the dataset card."""
    parts = ", ".join(
        f"{cause} unknown" if share is None else f"{cause} {share[0]:+.0%} to {share[1]:+.0%}"
        for cause, share in force_error(recipe).items()
    )
    when = (
        "follow the body's relaxation from frame to frame, with times that are scaled to a hardness reading 1 s after "
        "contact"
        if recipe.contact.rate_dependent
        else "are quasi-static, for the stiffness 1 s after contact"
    )
    thin = (
        f" A block of {recipe.design.height_mm:g} mm is below {LEAST_HEIGHT_MM:g} mm: its forces are too high by an "
        "unknown part."
        if recipe.design.height_mm < LEAST_HEIGHT_MM
        else ""
    )
    return (
        f"`force_n` comes with a stated error, in shares of it by which a real sensor may differ: {parts}.{thin} "
        f"Labels {when}; the same numbers stand in the metadata of the column."
    )


BEFORE = "Pictures of touches that the fast tier's model knows are emulated (`image_way`)."
"""What a card of the fast tier says before anything is rendered."""


def tier_sentence(emulated: int, touches: int, checked: Sequence[TierError]) -> str:
    """For the card: how many pictures of touches are emulated, and how far the checked ones are off true ones."""
    said = f"{emulated} of {touches} pictures of touches are emulated, all others true (`image_way`)."
    if not checked:
        return f"{said} None of them was rendered truly to compare."
    mean, p95, p99 = np.mean(checked, 0)
    return (
        f"{said} {len(checked)} of the emulated ones, drawn at random, were rendered truly as well: both differ by "
        f"{mean:.2f} linear grey levels in the mean, 95 % of values by less than {p95:.1f}, 99 % by less than "
        f"{p99:.1f}, the true frames' own noise included (`tier_mean`, `tier_p95`, `tier_p99`)."
    )


def card_header(license: str | None, tags: Iterable[str], splits: Iterable[str]) -> str:
    """The lines of a card's header, which name the files of each split."""
    licence = f"license: {json.dumps(license)}\n" if license is not None else ""
    files = "".join(f"\n  - split: {split}\n    path: data/{split}-*.parquet" for split in splits)
    labels = "\n".join(f"- {tag}" for tag in tags)
    return f"{licence}tags:\n{labels}\nconfigs:\n- config_name: default\n  default: true\n  data_files:{files}"


def card_columns(columns: Iterable[Column]) -> str:
    """The table of what columns mean."""
    rows = "\n".join(f"| `{column.name}` | {column.meaning} |" for column in columns)
    return f"| column | meaning |\n|---|---|\n{rows}"


def dataset_card(recipe: Recipe, columns: list[Column], versions: dict[str, str], tier: str | None = None) -> str:
    """Markdown with a YAML header that names the files of each split; of the fast tier with its `tier_sentence`."""
    tier = f"\n{tier or BEFORE}\n" if recipe.render.tier == "fast" else ""
    splits = Layout(recipe).splits
    made_by = ", ".join(f"{name} {version}" for name, version in versions.items())
    return f"""---
{card_header(recipe.license, ("robotics", "tactile", "synthetic"), splits)}
- config_name: sensors
  data_files:
  - split: train
    path: sensors.parquet
---

# Simulated frames of a see-through touch sensor

{recipe.episodes} episodes of objects in front of and against a soft block that a camera looks into (`config.toml` has
its design); simulated by {made_by}. Every value that was drawn is a column; `config.toml` is the recipe that
draws the same dataset again, with seed {recipe.seed}.
{_history(recipe)}
Units are mm, N, N mm, s and degrees. The sensor's frame is right-handed with its origin at the centre of the contact
face, x along the first and y along the second side of `footprint_mm`, +z from the contact face towards the camera;
objects come from -z. Force is what the object exerts on the sensor, so that a press is +z. Row 0 of an image is at +y,
column 0 at -x. The camera's frame has x to the right, y down and z ahead: `camera_rotation` turns it into the sensor's.

{as_sentence(recipe)}

{image_sentence(recipe)}
{tier}
```python
from datasets import load_dataset

frames = load_dataset("path/to/this/folder", split="{splits[0]}")
print(frames[0]["image"], frames[0]["force_n"])
```

{card_columns(columns)}

`sensors.parquet` has the design, rig, calibration and lattice of each printed sensor; `calibration.json` is that of the
sensor without tolerances; `manifest.json` lists every file with its SHA-256 (`magicsim dataset verify`).
"""


def _history(recipe: Recipe) -> str:
    """A sentence where frames are no independent draws."""
    camera = draw_episodes(recipe)[0].scene.rig.camera
    reasons = "; ".join(f"rig.{reason}" for reason in camera.history)
    return f"\nA frame depends on those of its episode before it ({reasons}).\n" if reasons else ""
