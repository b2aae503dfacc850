"""The dataset card: `README.md` whose header `datasets` reads."""

from magicsim.dataset.features import Column
from magicsim.dataset.force_error import as_sentence
from magicsim.dataset.layout import Layout
from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.recipe import Recipe


def dataset_card(recipe: Recipe, columns: list[Column], versions: dict[str, str]) -> str:
    """Markdown with a YAML header that names the files of each split."""
    splits = Layout(recipe).splits
    files = "\n".join(f"  - split: {split}\n    path: data/{split}-*.parquet" for split in splits)
    rows = "\n".join(f"| `{column.name}` | {column.meaning} |" for column in columns)
    made_by = ", ".join(f"{name} {version}" for name, version in versions.items())
    return f"""---
{_licence(recipe)}tags:
- robotics
- tactile
- synthetic
configs:
- config_name: default
  default: true
  data_files:
{files}
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

```python
from datasets import load_dataset

frames = load_dataset("path/to/this/folder", split="{splits[0]}")
print(frames[0]["image"], frames[0]["force_n"])
```

| column | meaning |
|---|---|
{rows}

`sensors.parquet` has the design, rig, calibration and lattice of each printed sensor; `calibration.json` is that of the
sensor without tolerances; `manifest.json` lists every file with its SHA-256 (`magicsim dataset verify`).
"""


def _licence(recipe: Recipe) -> str:
    return f"license: {recipe.license}\n" if recipe.license is not None else ""


def _history(recipe: Recipe) -> str:
    """A sentence where frames are no independent draws."""
    camera = draw_episodes(recipe)[0].scene.rig.camera
    reasons = "; ".join(f"rig.{reason}" for reason in camera.history)
    return f"\nA frame depends on those of its episode before it ({reasons}).\n" if reasons else ""
