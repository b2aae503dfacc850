import json
import subprocess
import sys
import sysconfig
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

import magicsim
from magicsim import cli
from magicsim.presets import preset_names

COARSE = ["uniform-block", "--set", "lattice.spacing_mm=2", "--set", "lattice.cells_across=0"]
BALL = ["--object", "sphere:radius_mm=4"]


class Shell:
    """Calls the command line inside this process."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
        self.monkeypatch, self.capsys = monkeypatch, capsys

    def __call__(self, *arguments: object) -> SimpleNamespace:
        self.monkeypatch.setattr(sys, "argv", ["magicsim", *map(str, arguments)])
        self.capsys.readouterr()
        code = 0
        try:
            cli.main()
        except SystemExit as stop:
            code = stop.code or 0
        captured = self.capsys.readouterr()
        return SimpleNamespace(code=code, out=captured.out, err=captured.err)

    def json(self, *arguments: object) -> dict[str, object]:
        done = self(*arguments, "--json")
        assert done.code == 0, done.err
        assert len(done.out.splitlines()) == 1
        return json.loads(done.out)

    def refusal(self, *arguments: object) -> str:
        done = self(*arguments)
        assert done.code == 2
        assert done.out == ""
        assert len(done.err.splitlines()) == 1
        assert done.err.startswith("magicsim: ")
        return done.err


@pytest.fixture
def shell(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Shell:
    monkeypatch.chdir(tmp_path)
    return Shell(monkeypatch, capsys)


def write_frames(folder: Path, count: int, *, rows: int = 32, columns: int = 24) -> Path:
    """Images of a dark grid on a bright ground."""
    folder.mkdir()
    row, column = np.indices((rows, columns))
    image = np.where((row % 6 < 2) | (column % 6 < 2), 10, 80).astype(np.uint8)
    for number in range(count):
        assert cv2.imwrite(str(folder / f"{number:03d}.png"), np.dstack([image] * 3))
    return folder


COMMANDS = (
    "demo", "simulate", "plan", "press", "durometer", "render", "calibration", "bench", "detect", "export", "doctor",
    "schema",
)  # fmt: skip


def test_help_names_every_command(shell: Shell):
    done = shell("--help")
    assert done.code == 0
    for command in COMMANDS:
        assert f" {command} " in done.out


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_takes_json_set_and_seed(shell: Shell, command: str):
    done = shell(command, "--help")
    assert done.code == 0
    assert all(option in done.out for option in ("--json", "--set", "--seed"))


def test_version_is_that_of_the_package(shell: Shell):
    assert shell("--version").out.strip() == magicsim.__version__


def test_plan_prints_decisions_with_stage_and_reason(shell: Shell):
    found = shell.json("plan", "demo")
    assert set(found) == {"kept", "left_out"}
    for decision in [*found["kept"], *found["left_out"]]:
        assert set(decision) == {"stage", "reason"}


def test_plan_without_json_is_text_for_people(shell: Shell):
    done = shell("plan", "near")
    assert done.code == 0
    assert "kept:\n  mesh and BVH update: 1 of 1 frames: something moved\n" in done.out


def test_override_and_seed_reach_the_scene(shell: Shell):
    found = shell.json(
        "plan", "near", "--set", "keyframes=[{frame=0}, {frame=6}]", "--set", "references=9", "--seed", 4
    )
    reasons = {decision["stage"]: decision["reason"] for decision in found["kept"]}
    assert reasons["reference frames"].startswith("9 frames")
    assert "seed = -4" in shell.refusal("plan", "near", "--seed", "-4")


def test_press_prints_the_contract_and_pushes_upwards(shell: Shell):
    found = shell.json("press", *COARSE, *BALL, "--depth-mm", 0.5)
    assert set(found) == {
        "force_n", "torque_nmm", "contact_area_mm2", "max_penetration_mm", "min_jacobian", "force_balance",
        "iterations", "cutbacks", "restarts", "shifted", "unknowns", "seconds", "converged",
    }  # fmt: skip
    assert len(found["force_n"]) == len(found["torque_nmm"]) == 3
    assert found["force_n"][2] > 0.5
    assert found["converged"] is True
    assert 0 < found["unknowns"] < 3 * 13 * 17 * 3  # coarser away from the contact


def test_press_off_centre_with_shear_is_accepted(shell: Shell):
    found = shell.json("press", *COARSE, *BALL, "--depth-mm", 0.3, "--shear-mm", "-0.5,0.5", "--twist-deg", -5)
    assert found["converged"] is True


@pytest.mark.parametrize("kind", ["design", "scene", "rig", "object", "profile"])
def test_schema_is_one_json_object_for_every_kind(shell: Shell, kind: str):
    found = shell.json("schema", kind)
    assert "properties" in found or "oneOf" in found


def test_doctor_prints_the_contract(shell: Shell):
    found = shell.json("doctor")
    assert {"variant", "llvm", "cores", "problems"} <= set(found)
    assert found["variant"] in {"llvm_ad_rgb", "scalar_rgb"}
    assert isinstance(found["problems"], list)


def test_calibration_describes_camera_and_layers(shell: Shell):
    found = shell.json("calibration", "rest", "--set", "rig.camera.distortion=[-0.1,0,0,0,0]")
    assert found["image_size"] == [240, 320]
    assert found["distortion"][0] == -0.1
    assert [layer["name"] for layer in found["layers"]][:2] == ["contact face", "grid 0"]
    assert "camera.distortion" in shell.refusal(
        "calibration", "rest", "--set", "rig.camera.distortion=[-1,-1,0,0,-1]", "--set", "rig.camera.distance_mm=4"
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--basis", "--out", "image.npy"), ".npz"),
        (("--relative-error", "0"), "relative_error = 0"),
        (("--relative-error", "0.1", "--basis"), "without basis"),
    ],
)
def test_render_refuses_options_that_do_not_fit(shell: Shell, options: tuple[str, ...], words: str):
    assert words in shell.refusal("render", "rest", *options)


def test_export_prints_the_contract_and_writes_the_file(shell: Shell, tmp_path: Path):
    found = shell.json("export", "uniform-block", "--out", "block.stl")
    assert {"watertight", "volume_mm3"} <= set(found)
    assert found["watertight"] is True
    assert found["volume_mm3"] == pytest.approx(24 * 32 * 6)
    assert (tmp_path / "block.stl").stat().st_size > 1000


def test_detect_prints_one_verdict_a_frame(shell: Shell, tmp_path: Path):
    reference, source = write_frames(tmp_path / "rest", 30), write_frames(tmp_path / "now", 2)
    found = shell.json("detect", source, "--reference", reference, "--profile", "published")
    assert list(found) == ["frames"]
    assert len(found["frames"]) == 2
    keys = {
        "entropy",
        "correlation",
        "similarity",
        "p_approach",
        "p_noise",
        "p_touch",
        "proximity",
        "contact",
        "combined",
    }
    assert keys <= set(found["frames"][0])
    assert found["frames"][0]["proximity"] == "Normal"
    assert found["frames"][0]["contact"] == "Untouched"


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
        (["simulat", "near"], '"simulat"'),
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
        (["detect", "nothing", "--reference", "nothing"], "'nothing' does not exist"),
        (["detect", "a.png", "--reference", "b.png", "--set", "tau_e=1"], "not allowed with detect"),
    ],
)
def test_bad_input_is_one_line_that_names_it(shell: Shell, tmp_path: Path, arguments: list[str], named: str):
    assert named in shell.refusal(*arguments)
    assert list(tmp_path.iterdir()) == []


def test_file_that_is_not_toml_is_one_line(shell: Shell, tmp_path: Path):
    (tmp_path / "broken.toml").write_text("schema_version =\n[")
    assert "broken.toml is not valid TOML" in shell.refusal("plan", "broken.toml")


@pytest.mark.parametrize("command", [["simulate", "near"], ["demo"]])
def test_folder_that_holds_other_files_is_refused_before_any_work(shell: Shell, tmp_path: Path, command: list[str]):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "config.toml").write_text("title = 'not ours'")
    assert "holds other files" in shell.refusal(*command, "--out", "out")
    assert (tmp_path / "out" / "config.toml").read_text() == "title = 'not ours'"


def test_image_of_size_zero_is_one_line_that_names_it(shell: Shell, tmp_path: Path):
    reference = write_frames(tmp_path / "rest", 30)
    (tmp_path / "empty.png").touch()
    assert "empty.png" in shell.refusal("detect", "empty.png", "--reference", reference)


def test_reference_of_another_size_is_one_line_with_both_sizes(shell: Shell, tmp_path: Path):
    reference, source = write_frames(tmp_path / "rest", 30), write_frames(tmp_path / "now", 1, rows=40, columns=30)
    message = shell.refusal("detect", source, "--reference", reference)
    assert "40" in message
    assert "32" in message


def test_folder_without_images_is_one_line(shell: Shell, tmp_path: Path):
    (tmp_path / "empty").mkdir()
    assert "empty" in shell.refusal("detect", "empty", "--reference", "empty")


def test_unknown_profile_lists_the_choices(shell: Shell, tmp_path: Path):
    frames = write_frames(tmp_path / "rest", 30)
    message = shell.refusal("detect", frames, "--reference", frames, "--profile", "publishd")
    assert "did you mean 'published'" in message
    assert all(name in message for name in preset_names("profile"))


@pytest.mark.parametrize(
    ("options", "estimator"),
    [([], "path"), (["--estimator", "fluence"], "fluence"), (["--estimator", "path"], "path")],
)
def test_render_keeps_the_estimator_of_the_scene_unless_asked(
    shell: Shell, monkeypatch: pytest.MonkeyPatch, options: list[str], estimator: str
):
    asked = []
    monkeypatch.setitem(
        sys.modules,
        "magicsim.still",
        SimpleNamespace(render_still=lambda scene, *_, **__: asked.append(scene), with_care=lambda scene, **_: scene),
    )
    monkeypatch.setattr(cli, "_fields", lambda _: {})
    shell.json("render", "near", "--set", "render.estimator=path", "--samples", 3, "--particles", 700, *options)
    assert asked[0].render.estimator == estimator
    assert (asked[0].render.samples, asked[0].render.particles) == (3, 700)


def test_interruption_ends_quietly(shell: Shell, monkeypatch: pytest.MonkeyPatch):
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("magicsim.plan.plan_scene", interrupt)
    done = shell("plan", "near")
    assert done.code == 130
    assert done.err == "magicsim: stopped\n"


def test_installed_command_reports_bad_input_with_exit_code_2(tmp_path: Path):
    command = [Path(sysconfig.get_path("scripts")) / "magicsim", "plan", "nera", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("magicsim: unknown scene 'nera'")
    assert len(done.stderr.splitlines()) == 1


SMALL = [
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=1.2", "rig.camera.columns=24", "rig.camera.rows=32",
    "rig.camera.field_mm=10", "render.samples=2", "render.particles=2000", "render.anchor_samples=2",
    "render.anchor_particles=2000", "references=6",
]  # fmt: skip


def settings(*more: str) -> list[str]:
    return [part for each in (*SMALL, *more) for part in ("--set", each)]


@pytest.mark.slow
def test_simulate_prints_the_contract_and_leaves_a_folder(shell: Shell, tmp_path: Path):
    found = shell.json("simulate", "near", "--out", "out", *settings())
    assert {"frames", "seconds", "variant", "contact_accuracy", "proximity_accuracy", "report"} <= set(found)
    assert found["frames"] == 7
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "config.toml", "episode.parquet", "frames", "lattice.parquet", "preview.webp", "report.html",
    ]  # fmt: skip
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    # The written configuration is a scene that runs again, in the same place.
    again = shell.json("simulate", tmp_path / "out" / "config.toml", "--out", "out")
    assert again["frames"] == 7


@pytest.mark.slow
@pytest.mark.parametrize("design", ["mini-magictac", "uniform-block"])
def test_render_prints_the_contract_and_writes_radiance(shell: Shell, tmp_path: Path, design: str):
    found = shell.json("render", "near", "--out", "image.npy", *settings(f"design={design}"))
    assert {"seconds", "estimator", "variant", "mean"} <= set(found)
    image = np.load(tmp_path / "image.npy")
    assert image.shape == (32, 24, 3)
    assert image.dtype == np.float32
    assert image.mean((0, 1)) == pytest.approx(found["mean"], rel=1e-5)
    assert (image >= 0).all()


@pytest.mark.slow
def test_render_of_perfectly_clear_materials_is_finite(shell: Shell):
    clear = ["design.materials.infill.sigma_s_per_mm=0", "design.materials.infill.absorption_per_mm=0"]
    found = shell.json("render", "near", *settings(*clear))
    assert all(np.isfinite(found["mean"]))
