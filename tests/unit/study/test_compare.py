from pathlib import Path

import pyarrow.parquet as pq
import pytest

from magicsim.errors import ConfigError
from magicsim.study import kinds
from magicsim.study.running import run_study
from magicsim.study.study_file import load_study

from .fakes import KINDS

FILE = """schema_version = 1
kind = "compare"
study = "{beam}"
others = ["mini-magictac-finger", "marker-type"]
[quick.study_changes]
forces_n = [5.0]
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch) -> Path:
    for kind, home in KINDS.items():
        monkeypatch.setitem(kinds.KINDS, kind, home)
    path = tmp_path / "mine.toml"
    path.write_text(FILE.format(beam=Path(__file__).with_name("beam.toml").as_posix()))
    return path


@pytest.mark.usefixtures("in_process")
def test_tables_of_all_designs_are_one_and_a_design_that_cannot_do_it_is_told(file: Path, out: Path):
    run_study(load_study(file), out, variant=lambda: "none")
    rows = pq.read_table(out / "tables/tips.parquet").to_pylist()
    assert [row["design"] for row in rows] == ["mini-magictac"] * 4 + ["mini-magictac-finger"] * 4
    compared = pq.read_table(out / "tables/compared.parquet").to_pylist()
    assert compared[0]["what"] == "most_mm"
    assert compared[0]["mini-magictac"] == rows[3]["tip_mm"]
    told = "marker-type is left out: study &#39;beam&#39; needs a design with a grid"
    assert told in (out / "report.html").read_text()
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    run_study(load_study(out / "config.toml"), out, resume=True, variant=lambda: "none")
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before


def test_quick_changes_the_compared_study_and_overrides_reach_it(file: Path):
    assert load_study(file, quick=True).config.study["forces_n"] == [5.0]
    assert load_study(file, ["study.forces_n=[7.0]"]).config.study["forces_n"] == [7.0]
    assert load_study(file, design="mini-magictac-rate").config.name == "mini-magictac-rate"


def test_bad_comparisons_are_one_line(file: Path):
    with pytest.raises(ConfigError, match="must all differ"):
        load_study(file, design="mini-magictac-finger")
    with pytest.raises(ConfigError, match="needs a design with a grid"):
        load_study(file, design="uniform-block")
    with pytest.raises(ConfigError, match="a comparison compares another study"):
        load_study(file, ["study=compare"])
    with pytest.raises(ConfigError, match="unknown key 'forces'"):
        load_study(file, ["study.forces=1"])


def test_single_constants_of_the_first_design_are_changed(file: Path):
    thick = "{name='thick skin',changes=['design.skin_mm=1.0','rig.camera.exposure_grey=70']}"
    config = load_study(file, [f"others=[{thick}]"]).config
    [other] = config.others
    assert (other.name, other.design.skin_mm, other.rig.camera.exposure_grey) == ("thick skin", 1.0, 70.0)
    assert other.design.core_mm == config.design.core_mm
    with pytest.raises(ConfigError, match="skin_mm"):
        load_study(file, ["others=[{name='odd',changes=['design.skin_mm=-1.0']}]"])
