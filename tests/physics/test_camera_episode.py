"""A camera with a history: the planner's shortcuts and other ways to the same frames change no byte."""

import io
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from magicsim.detectors.picture import read_image
from magicsim.evaluation.footage import ExposedTake
from magicsim.evaluation.take import film_take
from magicsim.robot.live import LiveSensor
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.simulation.main_job import run_scene
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.stream import simulate

TINY = (
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=2", "design.lattice.cells_across=0",
    "rig.camera.columns=24", "rig.camera.rows=32", "rig.camera.field_mm=10", "render.samples=2",
    "render.particles=2000", "render.anchor_samples=2", "render.anchor_particles=2000", "references=3",
    "object.radius_mm=4", "rig=digit-webcam",
)  # fmt: skip
STORY = (
    "keyframes=[{frame=0}, {frame=1,gap_mm=0.5}, {frame=2,gap_mm=-0.5}, {frame=3,gap_mm=-0.5}, {frame=4,gap_mm=0.5}, "
    "{frame=5,flashlight=true}, {frame=6}]"
)
LIT = (
    "rig.ambient=[0.2,0.2,0.2]", "rig.camera.shutter.moves=true",
    "keyframes=[{frame=0}, {frame=1,gap_mm=0.5}, {frame=3,gap_mm=0.5}, {frame=4}, {frame=5,gap_mm=0.5}, {frame=6}]",
)  # fmt: skip
"""Without a touch: what the renderer makes of a touch in a lit room depends on what it has rendered before."""


def story(*settings: str) -> SceneConfig:
    return load_scene("pressed", [*TINY, STORY, *settings], seed=5)


@pytest.fixture(scope="module", params=[(), pytest.param(LIT, marks=pytest.mark.slow)], ids=["dark", "lit"])
def scene(request: pytest.FixtureRequest) -> SceneConfig:
    return story(*request.param)


@pytest.fixture(scope="module")
def images(scene: SceneConfig) -> list[np.ndarray]:
    return [frame.image for frame in simulate(scene).frames]


def test_leaving_out_changes_no_frame(scene: SceneConfig, images: list[np.ndarray]):
    full = simulate(scene, plan=plan_scene(scene, leave_out=False)).frames
    assert all((a == b.image).all() for a, b in zip(images, full, strict=True))


def test_a_take_exposed_afterwards_has_the_same_frames(scene: SceneConfig, images: list[np.ndarray]):
    take = film_take(scene)
    exposed = ExposedTake(take=take, camera=scene.rig.camera, seed=scene.seed, frames_per_second=15.0, lit=scene.lit)
    again = [*exposed.references(), *exposed.frames()]
    assert all((a == b).all() for a, b in zip(images, again, strict=True))


def test_a_live_sensor_shows_the_same_frames_whether_earlier_ones_are_looked_at_or_not():
    scene = story("keyframes=[{frame=0}, {frame=1,gap_mm=0.5}, {frame=3,gap_mm=0.5}, {frame=4}]")
    expected = [frame.image for frame in simulate(scene).frames]
    here = Workspace(x_mm=(0, 0), y_mm=(0, 0), twist_deg=(0, 0), gap_mm=(0.1, 30))
    with LiveSensor(scene, workspace=here) as live:

        def moments():
            live.reset()
            for index in range(len(expected)):
                if index == 4:
                    live.move_to(gap_mm=0.5)
                if index == 7:
                    live.remove_object()
                yield live.grab()

        grabbed = list(moments())
        backwards = [live.develop(moment).image for moment in reversed(grabbed)][::-1]
        in_turn = [live.develop(moment).image for moment in moments()]
    assert all((a == b).all() for a, b in zip(expected, backwards, strict=True))
    assert all((a == b).all() for a, b in zip(expected, in_turn, strict=True))


def test_stored_frames_are_those_that_the_detectors_see(tmp_path: Path):
    scene = story("output.report=false", "output.preview=false", "references=0", "keyframes=[{frame=0},{frame=1}]")
    run_scene(scene, tmp_path / "out")
    for frame in simulate(scene).frames:
        assert (read_image(tmp_path / f"out/frames/{frame.truth.index:05d}.png") == frame.image).all()


def test_a_dataset_has_the_rows_of_the_simulated_scene():
    from dataset.fakes import decoded

    from magicsim.dataset.columns import columns_of
    from magicsim.dataset.recipes.draw import draw_episodes
    from magicsim.dataset.recipes.recipe import load_recipe
    from magicsim.dataset.rows import SampleTask, simulate_sample

    render = "render={samples=2, particles=2000, anchor_samples=2, anchor_particles=2000}"
    paths = "paths=[{kind='flashlight', lit_frames=2}]"
    small = [each for each in TINY if each.startswith(("design", "rig"))]
    recipe = load_recipe("default", [*small, render, paths, "references=2", "episodes=1"])
    episode = draw_episodes(recipe)[0]
    constants = {"config_hash": "0", "version": "0", "variant": "0"}
    table = simulate_sample(SampleTask(episode=episode, columns=columns_of(recipe), constants=constants))
    rows = pq.read_table(io.BytesIO(table)).to_pylist()
    frames = simulate(episode.scene).frames
    assert episode.scene.rig.camera.live is not None
    assert all((decoded(row["image"]) == frame.image).all() for row, frame in zip(rows, frames, strict=True))


def test_the_plan_says_that_frames_depend_on_those_before():
    assert "rig.camera.live: gains follow" in [each.reason for each in plan_scene(story()).kept]
    plain = plan_scene(load_scene("pressed"))
    assert "every frame in order" not in [each.stage for each in plain.kept]


def test_h264_frames_repeat_and_are_refused_where_frames_come_in_any_order():
    pytest.importorskip("av")
    scene = story("rig.camera.compression={kind='h264'}", "keyframes=[{frame=0},{frame=2}]")
    first, second = ([frame.image for frame in simulate(scene).frames] for _ in range(2))
    assert all((a == b).all() for a, b in zip(first, second, strict=True))
