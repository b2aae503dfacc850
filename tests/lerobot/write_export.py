"""Writes a small dataset in LeRobot's layout: `python write_export.py FOLDER`; read by `read_export.py`."""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "unit"))
from dataset.fakes import FAKE, small_recipe

from magicsim.dataset.export.formats import export_dataset
from magicsim.dataset.generate import generate_dataset
from magicsim.workers.attempt import WorkerOptions

if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as work:
        whole = Path(work) / "whole"
        generate_dataset(small_recipe("episodes=5"), whole, options=WorkerOptions(workers=1), simulator=FAKE)
        export_dataset(whole, Path(sys.argv[1]), "lerobot")
