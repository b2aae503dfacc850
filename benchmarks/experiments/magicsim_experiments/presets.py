"""Folders of the presets that come with the experiments; `magicsim` finds them by entry points."""

from pathlib import Path

_SCENES = Path(__file__).resolve().parent / "scenes"
STUDIES = _SCENES / "studies"
ITEMS = _SCENES / "items"
MODELS = _SCENES / "models"
"""Fitted models, found by their bare names, see `read_model`."""
