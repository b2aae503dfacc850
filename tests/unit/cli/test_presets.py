"""Every sensor by name goes through the commands that a new user tries first, at sizes that cost little."""

from pathlib import Path

import pytest
from dataset.fakes import FOLDER

from magicsim.judge.verdicts import COATED

from .conftest import Shell

OPAQUE = ("gelsight-type", "gelsight-type-markers", "translucent-9dtact")
PRESETS = ("mini-magictac-finger", "marker-type", "see-through-markers", *OPAQUE)
RIGS = {
    "mini-magictac-finger": "digit-rgb", "marker-type": "white-ring", "see-through-markers": "see-through-sides",
    "gelsight-type": "three-sides-rgb", "gelsight-type-markers": "three-sides-rgb",
    "translucent-9dtact": "translucent-ring",
}  # fmt: skip
SMALL = [
    "design.footprint_mm=[10,10]", "design.lattice.spacing_mm=1.5", "rig.camera.columns=24", "rig.camera.rows=24",
    "rig.camera.field_mm=8", "render.samples=1", "render.particles=2000",
]  # fmt: skip
FILM = [
    "references=30", "render.anchor_samples=1", "render.anchor_particles=2000", "output.preview=false",
    "keyframes=[{frame=0},{frame=1,gap_mm=2.0},{frame=2,gap_mm=-0.4}]",
]  # fmt: skip


def put(*settings: str) -> list[str]:
    return [word for each in settings for word in ("--set", each)]


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_is_exported_and_pressed(shell: Shell, tmp_path: Path, name: str):
    shell.json("export", name, "--out", "part.glb", *put("footprint_mm=[10,10]"))
    assert (tmp_path / "part.glb").stat().st_size > 1000
    coarse = put("footprint_mm=[10,10]", "lattice.spacing_mm=1.5", "lattice.cells_across=0")
    found = shell.json("press", name, "--object", "sphere:radius_mm=3", "--depth-mm", 0.4, *coarse)
    assert found["converged"] is True
    assert found["force_n"][2] > 0.05


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_is_filmed_and_judged(shell: Shell, name: str):
    filmed = shell.json("simulate", name, "--out", "run", *put(*SMALL, *FILM))
    assert filmed["frames"] == 33
    done = shell("detect", "run", "--profile", "published", "--json")
    if done.code:
        assert done.err.startswith("magicsim: ")
        assert done.err.count("\n") == 1
        return
    assert (COATED in done.out) is (name in OPAQUE)


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_is_previewed_as_a_dataset(shell: Shell, tmp_path: Path, name: str):
    settings = put(f"design={name}", f"rig={RIGS[name]}", "paths=[{kind='touch',depth_mm={low=0.3,high=0.4}}]", *SMALL)
    found = shell.json("dataset", FOLDER / "small.toml", "--out", "look", "--preview", 2, "--workers", 1, *settings)
    assert any((tmp_path / "look").iterdir()), found
