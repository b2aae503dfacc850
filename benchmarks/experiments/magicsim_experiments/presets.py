"""Folders of the presets that come with the experiments; `magicsim` finds them by entry points."""

from pathlib import Path

SCENES = Path(__file__).resolve().parent / "scenes"
RECIPES = SCENES / "recipes"
STUDIES = SCENES / "studies"
ITEMS = SCENES / "items"
