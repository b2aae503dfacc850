"""The script of the page on adding a study."""

import importlib.util
import json
import sys
from pathlib import Path

from magicsim_experiments.study.stages import PiecesStage
from magicsim_experiments.study.study_file import load_study

SCRIPT = Path(__file__).resolve().parents[2] / "docs" / "examples" / "own_study.py"
SMALL_BLOCK = ["footprint_mm=[12,12]", "lattice.cells_across=0"]


def test_own_study(tmp_path, monkeypatch):
    spec = importlib.util.spec_from_file_location("own_study", SCRIPT)
    script = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, script.__name__, script)
    spec.loader.exec_module(script)
    file = tmp_path / "balls.toml"
    file.write_text('schema_version = 1\nkind = "balls"\n')
    changes = [f"design.{each}" for each in SMALL_BLOCK] + ["design.lattice.spacing_mm=2"]
    study = load_study(file, changes, design="uniform-block", kinds={"balls": f"{script.__name__}:Balls"})
    found = [json.loads(script.ball_force(task)) for task in study.presses.tasks]
    assert 0 < found[0]["force_n"] < found[1]["force_n"]
    assert isinstance(study.stages()[0], PiecesStage)
    monkeypatch.setattr(script, "read_pieces", lambda *_: [json.dumps(each).encode() for each in found])
    assert study.conclude(tmp_path).headline["most_n"] == found[1]["force_n"]
