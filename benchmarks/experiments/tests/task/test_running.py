import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from magicsim.errors import ConfigError, OutputError, PresetError
from magicsim_experiments.task.running import GraspPlayer, run_grasps
from magicsim_experiments.task.settings import GraspConfig
from magicsim_experiments.task.world import Happened, World

ITEM = """schema_version = 1
mass_g = 20.0
friction = 0.8
crush_n = 10.0

[object]
kind = "sphere"
radius_mm = 4.0
"""
SMALL = (
    "rig.camera.exposure_grey=90", "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=2",
    "design.lattice.cells_across=0", "rig.camera.columns=24", "rig.camera.rows=32", "rig.camera.field_mm=10",
    "render.samples=1", "render.particles=2000", "render.anchor_samples=2", "render.anchor_particles=4000",
)  # fmt: skip


@pytest.fixture
def small(tmp_path: Path) -> GraspConfig:
    item = tmp_path / "ball.toml"
    item.write_text(ITEM)
    return GraspConfig(
        items=(str(item),), room="dark", scene=SMALL, most_frames=22, light_share=1, near_mm=(1.0, 1.1), grip_n=0.5
    )


def test_run_writes_what_it_saw_and_goes_on_where_it_was(small: GraspConfig, tmp_path: Path):
    out = tmp_path / "run"
    first = run_grasps(small, out, episodes=1, with_film=True)
    assert first.episodes == 1
    assert {path.name for path in out.iterdir()} == {
        "task.json", "config.toml", "results.json", "frames.parquet", "episodes.parquet", "episodes", "films",
    }  # fmt: skip
    rows = pq.read_table(out / "frames.parquet").to_pylist()
    assert [row["frame"] for row in rows] == list(range(len(rows)))
    assert {row["light"] for row in rows} == {True, False}
    assert json.loads((out / "results.json").read_text())["completed"]["of"] == 1
    with pytest.raises(OutputError, match="holds a run of a task already; --resume goes on with it"):
        run_grasps(small, out, episodes=2)
    before = (out / "episodes" / "00000.json").read_bytes()
    more = run_grasps(small, out, episodes=2, resume=True)
    assert more.episodes == 2
    assert (out / "episodes" / "00000.json").read_bytes() == before
    other = small.model_copy(update={"grip_n": 0.7})
    with pytest.raises(OutputError, match="holds another task"):
        run_grasps(other, out, episodes=2, resume=True)
    (out / "episodes" / "00001.json").write_text("{}")
    with pytest.raises(OutputError, match="not as magicsim wrote it"):
        run_grasps(small, out, episodes=2, resume=True)


def test_episode_that_fails_is_counted_and_the_run_goes_on(
    small: GraspConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    whole, steps = World.step, iter(range(99))

    def step(world: World, *arguments: object) -> Happened:
        if next(steps) == 3:
            raise ConfigError("y_mm = 9 is not allowed")
        return whole(world, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(World, "step", step)
    found = run_grasps(small, tmp_path / "run", episodes=2)
    assert (found.failed.count, found.failed.of) == (1, 2)
    assert found.reasons == {"y_mm = 9 is not allowed": 1}
    rows = pq.read_table(tmp_path / "run/episodes.parquet").to_pylist()
    assert [row["error"] for row in rows] == ["y_mm = 9 is not allowed", ""]
    assert [row["frames"] for row in rows] == [4, 22]


def test_unknown_parts_are_refused_before_anything_is_built():
    with pytest.raises(PresetError, match="unknown item 'pear'; available: banana, biscuit-packet, orange"):
        GraspPlayer(GraspConfig(items=("pear",)))
    with pytest.raises(ConfigError, match="room"):
        GraspPlayer(GraspConfig(room="cellar"))
