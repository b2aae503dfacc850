from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from magicsim.camera.exposure import meter
from magicsim.errors import MagicsimError
from magicsim.fit.constants import fitted_scene, with_values
from magicsim.fit.fitting import fit_constants
from magicsim.fit.model import Equilibria, compare, render_bases, whole_untouched
from magicsim.fit.observation import Observation, observe
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor
from magicsim.simulation.stream import simulate

SMALL = (
    "design.footprint_mm=[10,12]", "design.cell_mm=2.3", "rig.camera.columns=32", "rig.camera.rows=40",
    "rig.camera.field_mm=8", "rig.camera.exposure_grey=60", "render.samples=4", "render.particles=8000",
    "render.anchor_samples=32", "render.anchor_particles=200000", "references=8",
)  # fmt: skip


def scene(seed: int) -> SceneConfig:
    return load_scene("rest", SMALL, seed=seed)


@pytest.mark.slow
def test_images_of_a_sensor_with_another_constant_give_it_back(tmp_path: Path):
    """With other random numbers than those of the fit, so that nothing agrees by chance."""
    true = 0.15
    other = with_values(scene(9), {"design.materials.infill.sigma_s_per_mm": true, "rig.strips.*.reflectance": 0.3})
    shown = observe([each.image for each in simulate(other).references], scene(3).rig.camera)
    out = tmp_path / "mine.toml"
    found = fit_constants(scene(3), [shown], out, free=["infill_scattering"], blocks=(5, 4), starts=1, evaluations=6)
    (scattering,) = found.constants
    assert scattering.determined
    assert abs(np.log(scattering.value / true)) < 3 * scattering.sd_share * np.log(scattering.high / scattering.low)
    assert scattering.value == pytest.approx(true, rel=0.1)
    assert found.rms < 0.5 * found.start_rms
    assert max(found.mean_rms) < 2.5
    sensor = Sensor.for_scene(load_scene(out))
    radiance, camera = sensor.radiance(UNTOUCHED, sensor.rest), sensor.rig.camera
    levels = 255 * (radiance.mean((0, 1)) * meter(radiance, camera))
    assert levels == pytest.approx(shown.mean.mean((0, 1)), rel=0.05)
    assert (tmp_path / "mine.png").read_bytes().startswith(b"\x89PNG")
    assert out.read_text().startswith("# Written by magicsim fit optics from 8 frames of 1 states")


def test_exposure_of_a_camera_that_reads_a_part_is_that_of_the_whole_image():
    settings = (
        "rig.camera.field_mm=16", "rig.camera.exposure_grey=20", "rig.camera.region_px=[10,12,12,16]", "references=2",
        "render.anchor_particles=40000", "render.anchor_samples=8",
    )  # fmt: skip
    part = load_scene("rest", (*SMALL, *settings), seed=3)
    shown = observe([each.image for each in simulate(part).references], part.rig.camera)
    found = compare(render_bases(part, {}, [UNTOUCHED], Equilibria()), [shown], part.rig.camera, blocks=(2, 2))
    assert found.images[0].mean() > 1.3 * 20  # the rest of the image shows less of the block
    fitted = fitted_scene(part, {}, found.strengths, whole_untouched(part, {}, found.strengths))
    assert fitted.rig.camera.exposure_grey == pytest.approx(20, rel=0.05)


@pytest.fixture
def plain() -> Observation:
    return observe([np.full((40, 32, 3), 60, np.uint8)], scene(0).rig.camera)


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"free": ["infil_ior"]}, "did you mean 'infill_ior'"),
        ({"free": ["exposure"]}, "'exposure' cannot be fitted to mean frames"),
        ({"free": []}, "no constant is free"),
        ({"starts": 0}, "starts = 0 is not allowed"),
        ({"blocks": (99, 1)}, "blocks = 99x1 is not allowed: must be 1x1 to 10x8"),
        ({"out": Path("a.txt")}, "must end in .toml"),
        ({"out": Path("none/a.toml")}, "no such folder"),
        ({"out": Path("loop/a.toml")}, "Too many levels of symbolic links"),
    ],
)
def test_bad_input_is_refused_before_anything_is_rendered(
    plain: Observation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changed: dict[str, object], named: str
):
    monkeypatch.chdir(tmp_path)
    Path("loop").symlink_to("loop")
    monkeypatch.setattr("magicsim.fit.fitting.render_bases", lambda *_, **__: pytest.fail("rendered"))
    with pytest.raises(MagicsimError, match=named.replace("(", r"\(")):
        fit_constants(scene(0), [plain], **{"out": Path("a.toml"), **changed})  # type: ignore[arg-type]
    assert [path.name for path in tmp_path.iterdir()] == ["loop"]


def test_states_must_be_those_of_the_scene_with_the_untouched_one_first(plain: Observation, tmp_path: Path):
    lit = replace(plain, frame=5)
    with pytest.raises(MagicsimError, match="frame = 5 is not allowed: must be 0 to 0"):
        fit_constants(scene(0), [plain, lit], tmp_path / "a.toml")
    with pytest.raises(MagicsimError, match="untouched sensor are missing"):
        fit_constants(scene(0), [lit], tmp_path / "a.toml")


def test_scene_outside_an_assumed_range_is_refused(plain: Observation, tmp_path: Path):
    far = with_values(scene(0), {"design.materials.infill.ior": 1.6})
    with pytest.raises(MagicsimError, match=r"infill\.ior = 1\.6 is not allowed: must be in its assumed range"):
        fit_constants(far, [plain], tmp_path / "a.toml")
