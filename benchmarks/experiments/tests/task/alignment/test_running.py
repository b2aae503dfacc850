"""The closed loop on a small block; PyTorch is optional."""

import json
import math
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest

from magicsim.errors import ConfigError, OutputError
from magicsim.robot.grip.load import Hold
from magicsim.robot.gripper import Gripper
from magicsim_experiments.learn.model_file import ModelConfig
from magicsim_experiments.learn.samples import Label
from magicsim_experiments.task.alignment.episode import play
from magicsim_experiments.task.alignment.grip import AlignmentConfig, Grip, build_gripper, grip_scene
from magicsim_experiments.task.settings import load_item

ITEM = """schema_version = 1
mass_g = 10.0
friction = 0.8
crush_n = 10.0

[object]
kind = "cylinder"
radius_mm = 4.0
length_mm = 8.0
edge_radius_mm = 1.0
"""
SMALL = (
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=2", "design.lattice.cells_across=0",
    "rig.camera.exposure_grey=90", "rig.camera.field_mm=10", "rig.room='dark'", "rig.ambient=[0,0,0]",
    "render.samples=1", "render.particles=2000", "render.anchor_samples=2", "render.anchor_particles=4000",
)  # fmt: skip
MODEL = ModelConfig(
    network="small", labels=(Label(name="p_x", unit="mm"), Label(name="r_z", unit="deg")), input="difference",
    long_side_px=0, frame_rows=32, frame_columns=24, input_mean=(0.0,) * 3, input_sd=(0.1,) * 3,
    target_mean=(0.0, 0.0), target_sd=(1.0, 20.0), study="alignment",
)  # fmt: skip


def changed(**values: object) -> ModelConfig:
    """The model with other values."""
    return MODEL.model_copy(update=values)


@pytest.fixture
def small(tmp_path: Path) -> AlignmentConfig:
    item = tmp_path / "rod.toml"
    item.write_text(ITEM)
    return AlignmentConfig(
        design="uniform-block", items=(str(item),), scene=SMALL, quality="control", frames=3, grip_n=0.6, references=1,
        askew_deg=(10, 20), aside_mm=0.5, gain_per_s=8.0, wrist_deg_s=100.0, sees_other=False,
    )  # fmt: skip


@pytest.fixture
def unrendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Frames of noise instead of rendered ones, their truth as it is."""
    random = np.random.default_rng(1)

    def frames(gripper: Gripper) -> SimpleNamespace:
        upper, lower = (random.integers(0, 255, (32, 24, 3), dtype=np.uint8) for _ in range(2))
        truth = gripper.truth()
        return SimpleNamespace(upper=SimpleNamespace(image=upper), lower=SimpleNamespace(image=lower), truth=truth)

    monkeypatch.setattr(Gripper, "frames", frames)


class Knowing:
    """A reader that knows the truth, each finger off by as much to the other side."""

    def __init__(self, gripper) -> None:
        self.gripper = gripper

    def learn(self, upper, lower) -> None:
        assert len(upper) == len(lower) == 1

    def read(self, upper, lower) -> tuple[float, float]:
        assert upper.shape == lower.shape == (32, 24, 3)
        angle = self.gripper.place.twist_deg
        return angle + 4, angle - 4


@pytest.mark.usefixtures("unrendered")
def test_right_readings_turn_the_item_upright_and_gravity_in_the_grip(small: AlignmentConfig):
    item = load_item(small.items[0])
    with build_gripper(grip_scene(small, item, MODEL), small) as gripper:
        grip = Grip(item="rod", askew_deg=20.0, x_mm=0.3, y_mm=0.0)
        found = play(gripper, Knowing(gripper), grip, item, small, episode=0, seed=1)
        load = gripper.truth().load
    assert not found.error
    assert not found.is_dropped
    errors = [row.error_deg for row in found.rows]
    assert errors[0] == pytest.approx(20.0, abs=0.5)
    for before, after in pairwise(errors):
        assert after == pytest.approx(0.2 * before if 0.8 * before < 10 else before - 10, abs=0.3)
    assert found.rows[-1].upper_n == pytest.approx(0.6, rel=0.15)
    wrist = found.rows[-1].wrist_deg
    assert wrist == pytest.approx(-18.0, abs=0.5)
    assert load.down[0] == pytest.approx(math.sin(math.radians(wrist)))  # gravity leans to -x in the turned gripper


@pytest.mark.usefixtures("unrendered")
def test_run_writes_what_it_saw_and_grows(small: AlignmentConfig, tmp_path: Path, model: Path):
    from magicsim_experiments.task.alignment.running import run_alignment

    first = run_alignment(small, model, tmp_path / "run", episodes=1)
    assert (first.episodes, first.failed.count) == (1, 0)
    names = {path.name for path in (tmp_path / "run").iterdir()}
    assert names == {
        "task.json", "config.toml", "results.json", "frames.parquet", "episodes.parquet", "episodes", "error.png",
        "pictures",
    }  # fmt: skip
    rows = pq.read_table(tmp_path / "run/frames.parquet").to_pylist()
    assert [row["frame"] for row in rows] == list(range(3))
    assert all(row["read_deg"] == pytest.approx((row["upper_deg"] + row["lower_deg"]) / 2) for row in rows)
    before = (tmp_path / "run/episodes/00000.json").read_bytes()
    with pytest.raises(OutputError, match="--resume goes on with it"):
        run_alignment(small, model, tmp_path / "run", episodes=2)
    assert run_alignment(small, model, tmp_path / "run", episodes=2, resume=True).episodes == 2
    assert (tmp_path / "run/episodes/00000.json").read_bytes() == before
    with pytest.raises(OutputError, match="holds another task"):
        run_alignment(small.model_copy(update={"grip_n": 2.0}), model, tmp_path / "run", episodes=2, resume=True)
    assert json.loads((tmp_path / "run/results.json").read_text())["seen"]["upright"]["of"] == 2


@pytest.mark.usefixtures("unrendered")
def test_episode_that_fails_is_counted_and_the_run_goes_on(
    small: AlignmentConfig, tmp_path: Path, model: Path, monkeypatch: pytest.MonkeyPatch
):
    from magicsim_experiments.task.alignment.running import run_alignment

    whole, holds = Gripper.hold, iter(range(99))

    def hold(gripper: Gripper, *arguments, **options) -> Hold:
        if next(holds) == 1:
            raise ConfigError("x_mm = 9 is not allowed")
        return whole(gripper, *arguments, **options)

    monkeypatch.setattr(Gripper, "hold", hold)
    found = run_alignment(small, model, tmp_path / "run", episodes=2)
    assert (found.failed.count, found.failed.of) == (1, 2)
    assert found.reasons == {"x_mm = 9 is not allowed": 1}
    assert found.seen.end_deg.episodes == 1


@pytest.mark.slow
def test_rendered_frames_are_read(small: AlignmentConfig, tmp_path: Path, model: Path):
    from magicsim_experiments.task.alignment.running import run_alignment

    facing = small.model_copy(update={"frames": 2, "sees_other": True, "design": "mini-magictac"})
    assert run_alignment(facing, model, tmp_path / "run", episodes=1).seen.episodes == 1


def test_model_that_does_not_fit_is_one_line(small: AlignmentConfig, tmp_path: Path, model: Path, make_model):
    from magicsim_experiments.task.alignment.running import AlignmentPlayer

    with pytest.raises(ConfigError, match=r"does not exist: 'magicsim study alignment --out DIR' makes one"):
        AlignmentPlayer(small, tmp_path / "none")
    blind = make_model(changed(labels=(Label(name="gap"), Label(name="p_x"))), "blind")
    with pytest.raises(ConfigError, match=r"tells gap, p_x and not r_z: 'magicsim study alignment"):
        AlignmentPlayer(small, blind)
    wide = make_model(changed(frame_columns=64), "wide")
    with pytest.raises(ConfigError, match=r"takes frames of 64 x 32 pixels, .* of the rig's 240 x 320"):
        AlignmentPlayer(small, wide)


@pytest.fixture
def make_model(tmp_path: Path):
    """Writes a model file with random weights."""
    torch = pytest.importorskip("torch")
    pytest.importorskip("safetensors")
    from magicsim_experiments.learn.model_file import save_model
    from magicsim_experiments.learn.networks import build_network

    def made(config: ModelConfig, name: str) -> Path:
        torch.manual_seed(1)
        path = tmp_path / f"{name}.safetensors"
        path.write_bytes(save_model(config, build_network("small", len(config.labels)).state_dict()))
        return path

    return made


@pytest.fixture
def model(make_model) -> Path:
    return make_model(MODEL, "model")
