import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from .conftest import Shell
from .small import settings


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
        "magicsim.simulation.still",
        SimpleNamespace(
            render_still=lambda scene, *_, **__: asked.append(scene) or {}, with_care=lambda scene, **_: scene
        ),
    )
    shell.json("render", "near", "--set", "render.estimator=path", "--samples", 3, "--particles", 700, *options)
    assert asked[0].render.estimator == estimator
    assert (asked[0].render.samples, asked[0].render.particles) == (3, 700)


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
