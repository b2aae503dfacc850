import signal
import subprocess
import sysconfig
from pathlib import Path

import pytest

import magicsim
from magicsim.cli.entry import EARLIER, app, present_words
from magicsim.config.presets import COMMANDS as ADDED_COMMANDS
from magicsim.config.presets import EXPERIMENTS, extensions
from magicsim.folder import result_folder

from .conftest import Shell

COMMANDS = tuple(command for command in app if not command.startswith("-") and app[command].show)
ANSWERS_ABOUT_ITSELF = (("info", "completion"), ("info", "list"))
"""Commands that compute nothing, so that there is nothing to set."""


def forms() -> list[tuple[str, ...]]:
    """Every command, and every form of those that have several."""
    inner = {name: [each for each in app[name] if not each.startswith("-")] for name in COMMANDS}
    found = [(name,) for name in COMMANDS if app[name].default_command is not None]
    return [*found, *((name, each) for name, below in inner.items() for each in below)]


RUN = [each for each in forms() if each not in ANSWERS_ABOUT_ITSELF and each[0] not in EXPERIMENTS]

COARSE = ["uniform-block", "--set", "lattice.spacing_mm=2", "--set", "lattice.cells_across=0"]
BALL = ["--object", "sphere:radius_mm=4"]


def test_help_names_every_command(shell: Shell):
    done = shell("--help")
    assert done.code == 0
    for command in COMMANDS:
        assert f" {command} " in done.out


@pytest.mark.parametrize("command", RUN, ids=" ".join)
def test_every_command_takes_json_set_and_seed(shell: Shell, command: tuple[str, ...]):
    done = shell(*command, "--help")
    assert done.code == 0
    assert all(option in done.out for option in ("--json", "--set", "--seed"))


def test_bench_says_in_one_line_where_it_is(shell: Shell):
    done = shell("bench", "render", "--quick", "--out", "there")
    assert done.code == 2
    assert done.err == "magicsim: bench is a script of the repository now: python benchmarks/render.py\n"


@pytest.mark.skipif(bool(extensions(ADDED_COMMANDS)), reason="the experiments are installed")
@pytest.mark.parametrize("words", ["study ranging --out DIR", "task grasp", "list studies", "schema item"])
def test_word_of_the_experiments_says_what_to_install(shell: Shell, words: str):
    named = next(word for word in words.split() if word in EXPERIMENTS)
    line = f"magicsim: '{named}' comes with magicsim-experiments, which is not installed: "
    assert shell.refusal(*words.split()) == f"{line}pip install ./benchmarks/experiments\n"


@pytest.mark.parametrize(("earlier", "now"), EARLIER.items())
def test_earlier_name_of_a_command_is_known(shell: Shell, earlier: str, now: tuple[str, str]):
    assert present_words([earlier, "--json"]) == [*now, "--json"]
    assert f"│ {earlier} " not in shell("--help").out


def test_earlier_name_works_and_says_the_present_one(shell: Shell):
    done = shell("calibration", "rest", "--json")
    assert (done.code, done.err) == (0, "magicsim: 'calibration' is 'info camera' now\n")
    assert done.out == shell("info", "camera", "rest", "--json").out
    assert shell.refusal("plan", "nera") == shell.refusal("simulate", "plan", "nera")


def test_fit_without_a_word_fits_optics(shell: Shell):
    assert present_words(["fit", "images", "--out", "x"]) == ["fit", "optics", "images", "--out", "x"]
    assert present_words(["fit", "images", "--out", "profile"]) == ["fit", "optics", "images", "--out", "profile"]
    assert present_words(["fit", "profile", "run"]) == ["fit", "profile", "run"]


def test_version_is_that_of_the_package(shell: Shell):
    assert shell("--version").out.strip() == magicsim.__version__


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["plan", "near", "--set", "render.sample=3"], "unknown key in [render] 'sample' (did you mean 'samples'?)"),
        (
            ["plan", "near", "--set", "rig.camera.clumns=3"],
            "unknown key in [rig.camera] 'clumns' (did you mean 'columns'",
        ),
        (["plan", "near", "--set", "references"], "is not of the form dotted.key=value"),
        (["plan", "near", "--set", "seed.x=3"], "'seed' is a value, not a table"),
        (["plan", "near", "--set", "design.skin_mm=-0.5"], "design.skin_mm = -0.5 is not allowed"),
        (["plan", "nera"], "unknown scene 'nera' (did you mean 'near'?)"),
        (["plan", "missing.toml"], "scene file 'missing.toml' does not exist"),
        (["plan", "near", "--set", "rig=missing.toml"], "rig file 'missing.toml' does not exist"),
        (["plan"], "scene"),
        (["plan", "near", "--seed", "first"], '"first"'),
        (["plan", "near", "--sed", "3"], "--sed"),
        (["simulat", "near"], "unknown command 'simulat' (did you mean 'simulate'?)"),
        (["simulate", "nera"], "unknown scene 'nera'"),
        (["demo", "--threads", "0"], "threads = 0 is not allowed"),
        (["export", "mini-magictac", "--set", "skin_mm=-1", "--out", "a.stl"], "skin_mm = -1 is not allowed"),
        (["export", "mini-magictac", "--set", "cell_mm=0.1", "--out", "a.stl"], "cell_mm = 0.1 is not allowed"),
        (
            ["export", "mini-magictac", "--set", "core_mm=1", "--set", "cell_mm=3", "--out", "a.stl"],
            "no cell fits along z",
        ),
        (["export", "mini-magictac", "--out", "a.obj"], "must end in .stl"),
        (["export", "mini-magitac", "--out", "a.stl"], "did you mean 'mini-magictac'"),
        (["press", *COARSE, "--object", "sphre:radius_mm=4", "--depth-mm", "1"], "unknown object kind 'sphre'"),
        (["press", *COARSE, "--object", "sphere:radius=4", "--depth-mm", "1"], "unknown key 'radius'"),
        (["press", *COARSE, "--object", "sphere:radius_mm=-4", "--depth-mm", "1"], "radius_mm = '-4'"),
        (["press", *COARSE, *BALL, "--depth-mm", "nan"], "depth_mm = nan is not allowed"),
        (["press", *COARSE, *BALL, "--depth-mm", "-1"], "depth_mm = -1 is not allowed"),
        (["press", *COARSE, *BALL, "--depth-mm", "6"], "depth_mm = 6 is not allowed"),
        (["press", *COARSE, *BALL, "--depth-mm", "deep"], '"deep"'),
        (["press", *COARSE, *BALL], "--depth-mm"),
        (["press", *COARSE, *BALL, "--depth-mm", "1", "--shear-mm", "1"], "shear_mm = '1' is not allowed"),
        (["press", *COARSE, *BALL, "--depth-mm", "1", "--shear-mm", "nan,0"], "shear_mm along x = nan"),
        (["press", *COARSE, *BALL, "--depth-mm", "1", "--friction", "-0.5"], "friction = -0.5 is not allowed"),
        (["render", "near", "--estimator", "photons"], '"photons"'),
        (["render", "near", "--samples", "0"], "render.samples = 0 is not allowed"),
        (["render", "near", "--frame", "1"], "frame = 1 is not allowed: must be 0 to 0"),
        (["render", "near", "--frame", "-1"], "frame = -1 is not allowed: must be 0 to 0"),
        (["render", "near", "--out", "image.png"], "must end in .npy"),
        (["schema", "sensor"], '"sensor"'),
        (
            ["press", *COARSE, *BALL, "--depth-mm", "1", "--points", "2.5"],
            "--points: 2.5 is not allowed: must be a whole num",
        ),
        (["render", "near", "--samples", "1.0e400"], "--samples: 1.0e400 is not allowed: must be a whole num"),
        (["plan", "near", "--seed", "0.5"], "--seed: 0.5 is not allowed: must be a whole num"),
        (["dataset", "default", "--out", "d", "--workers=.5"], "--workers: .5 is not allowed: must be a whole num"),
        (["live", "near", "--port", "1.2.3"], "--port: 1.2.3 is not allowed: must be a whole num"),
        (["press", *COARSE, "--object", "sphere:radius_mm=3,radius_mm=4", "--depth-mm", "1"], "radius_mm is given tw"),
        (["dataset", "defualt", "--out", "d"], "unknown recipe 'defualt' (did you mean 'default'?)"),
        (["dataset", "default"], "--out"),
        (["dataset", "default", "--out", "d", "--workers", "0"], "workers = 0 is not allowed"),
        (
            ["dataset", "default", "--out", "d", "--workers", "2", "--cluster", "tcp://a:1"],
            "not allowed with a cluster",
        ),
        (["dataset", "default", "--out", "d", "--set", "episodes=0"], "episodes = 0 is not allowed"),
        (["dataset", "default", "--out", "d", "--set", "tolerance.skin_mm=0"], "did you mean 'tolerances'"),
        (["dataset", "verify", "nothing"], "'nothing' holds no dataset: manifest.json is missing"),
        (["detect", "nothing", "--reference", "nothing"], "'nothing' does not exist"),
        (["detect", "a.png", "--reference", "b.png", "--set", "tau_e=1"], "not allowed with detect"),
        (["evaluate", "smal"], "unknown suite 'smal' (did you mean 'small'?)"),
        (["evaluate", "--profile", "calibrted"], "did you mean 'calibrated'"),
        (["evaluate", "--detector", "nowhere:Thing"], "cannot be imported"),
        (["evaluate", "--detector", "a:B", "--profile", "published"], "not allowed with --detector"),
        (["evaluate", "--baseline", "missing.json"], "baseline: cannot read missing.json"),
        (["evaluate", "--save-baseline", "."], "output file '.' is a folder; name a file"),
        (["evaluate", "--set", "resamples=3"], "resamples = 3 is not allowed"),
    ],
)
def test_bad_input_is_one_line_that_names_it(shell: Shell, tmp_path: Path, arguments: list[str], named: str):
    assert named in shell.refusal(*arguments)
    assert list(tmp_path.iterdir()) == []


def test_file_that_is_not_toml_is_one_line(shell: Shell, tmp_path: Path):
    (tmp_path / "broken.toml").write_text("schema_version =\n[")
    assert "broken.toml is not valid TOML" in shell.refusal("plan", "broken.toml")


def test_interruption_ends_quietly(shell: Shell, monkeypatch: pytest.MonkeyPatch):
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("magicsim.simulation.plan.plan_scene", interrupt)
    done = shell("plan", "near")
    assert done.code == 130
    assert done.err == "magicsim: stopped\n"


def test_termination_leaves_nothing_half_written(shell: Shell, monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    def terminate(*_: object) -> None:
        with result_folder(tmp_path / "out") as folder:
            (folder / "half").write_text("")
            signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr("magicsim.simulation.plan.plan_scene", terminate)
    assert shell("plan", "near").code == 143
    assert list(tmp_path.iterdir()) == []


def test_a_reader_that_has_gone_is_no_error(tmp_path: Path):
    command = [Path(sysconfig.get_path("scripts")) / "magicsim", "schema", "scene"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()
        assert running.stderr.read() == ""
    assert running.returncode == 141


def test_installed_command_reports_bad_input_with_exit_code_2(tmp_path: Path):
    command = [Path(sysconfig.get_path("scripts")) / "magicsim", "plan", "nera", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("magicsim: unknown scene 'nera'")
    assert len(done.stderr.splitlines()) == 1
