"""The card of a dataset of recorded frames: `README.md` whose header `datasets` reads."""

from collections.abc import Sequence

from magicsim.dataset.features import Column
from magicsim.real.description import Description


def real_card(description: Description, columns: Sequence[Column], splits: Sequence[str]) -> str:
    """Markdown with a YAML header that names the files of each split."""
    licence = f"license: {description.license}\n" if description.license is not None else ""
    files = "\n".join(f"  - split: {split}\n    path: data/{split}-*.parquet" for split in dict.fromkeys(splits))
    rows = "\n".join(f"| `{column.name}` | {column.meaning} |" for column in columns)
    return f"""---
{licence}tags:
- robotics
- tactile
configs:
- config_name: default
  default: true
  data_files:
{files}
---

# Recorded frames of a touch sensor

Frames of a real sensor with their labels, in the columns of a dataset that magicsim simulates; `real.toml` says where
they came from and what was done to them. What nobody labelled is empty or a number that is none;
the flashlight counts as off.

| column | meaning |
|---|---|
{rows}
"""
