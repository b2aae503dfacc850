from pathlib import Path

import pyarrow.parquet as pq
import pytest
import tomli_w

from magicsim.errors import ConfigError
from magicsim_experiments.study import study_file
from magicsim_experiments.study.compare import TAKEN
from magicsim_experiments.study.protocol import FOLDER
from magicsim_experiments.study.running import run_study
from magicsim_experiments.study.study_file import load_study

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
        monkeypatch.setitem(study_file.KINDS, kind, home)
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


@pytest.mark.parametrize(
    ("setting", "named"),
    [
        ("others=true", "others = True is not allowed: must be a list of designs, names or tables"),
        ("others=5", "others = 5 is not allowed: must be a list"),
        ("others=1e300", r"others = 1e\+300 is not allowed: must be a list"),
        ("others='mini-magictac'", "others = 'mini-magictac' is not allowed: must be a list"),
        ("others=[5]", "others holds 5, which is not allowed: must be a name or a table"),
        ("study_changes=5", "study_changes = 5 is not allowed: must be a table"),
        ("study_changes=[]", r"study_changes = \[\] is not allowed: must be a table"),
        (
            "study_changes={quick=5}",
            r"study_changes\.quick = 5 is not allowed: must be a setting of the compared study",
        ),
        ("study_changes={seed=5}", r"study_changes\.seed = 5 is not allowed"),
        ("study_changes={force_n=[1.0]}", "unknown key 'force_n'"),
        ("study={kind='beam',quick=5}", "study: quick = 5 is not allowed: must be a table"),
        ("name=5", "name = 5 is not allowed"),
        ("name=[]", r"name = \[\] is not allowed"),
        ("name='../x'", r"name: '\.\./x' is not allowed as a name: must be letters"),
        ("name='study.json'", r"name: 'study\.json' is not allowed as a name: a study has a file or folder"),
        ("others=[{name='Tables'}]", r"others\.0\.name: 'Tables' is not allowed as a name: a study has"),
        ("others=[{name='../x'}]", r"others\.0\.name: '\.\./x' is not allowed as a name: must be"),
    ],
)
def test_wrong_settings_of_a_comparison_are_one_line(file: Path, setting: str, named: str):
    with pytest.raises(ConfigError, match=named):
        load_study(file, [setting])


@pytest.mark.parametrize("name", TAKEN)
def test_design_cannot_be_called_as_what_every_study_writes(file: Path, name: str):
    with pytest.raises(ConfigError, match="a study has a file or folder that is called so"):
        load_study(file, [f"others=[{{name='{name}',changes=['design.skin_mm=1.0']}}]"])


def test_first_design_is_called_as_the_settings_say_until_it_is_another(file: Path, tmp_path: Path):
    config = load_study(file, ["name='walls of 0.2 mm'"]).config
    assert config.name == "walls of 0.2 mm"
    kept = tmp_path / "kept.toml"
    kept.write_text(tomli_w.dumps(config.model_dump(mode="json", exclude_none=True)))
    assert load_study(kept).config == config
    assert load_study(kept, design="mini-magictac-rate").config.name == "mini-magictac-rate"
    assert load_study(kept, ["name=mine"], design="mini-magictac-rate").config.name == "mine"


def test_names_that_a_study_writes_are_all_taken():
    written = {FOLDER.index, "config.toml", "report.html", "results.json", "tables", "data", "pieces", "models"}
    assert written <= set(TAKEN)
