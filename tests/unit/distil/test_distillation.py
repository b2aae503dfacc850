"""From a recipe to a model that a sensor uses: small, real, resumed; and what it says of itself."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from magicsim.config.presets import preset_root
from magicsim.config.program import versions
from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.distil.distillation import distil, example_name, measure
from magicsim.distil.examples import Example, ExampleTask, is_held_out, render_example
from magicsim.distil.network import build_network, start_from
from magicsim.distil.training import CHECKPOINT, Library, Training
from magicsim.emulator.emulator import EMULATED
from magicsim.emulator.model import MODELS, TouchModel
from magicsim.errors import ConfigError, OutputError
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.sensor import Sensor
from magicsim.workers.attempt import WorkerOptions

SMALL = (
    "rig.camera.columns=48", "rig.camera.rows=64", "render.samples=1", "render.particles=1000",
    "render.anchor_samples=2", "render.anchor_particles=2000", "episodes=9", "rooms=[]", "rig.room=dark",
    "design.lattice.cells_across=0",
    "tolerances={}", "objects=[{kind='sphere',radius_mm={low=3.0,high=6.0}}]",
    "paths=[{kind='touch',gap_mm=0.1,x_mm={low=-2.0,high=2.0},depth_mm={low=0.5,high=1.0},approach_frames=1,press_frames=2,"
    "shear_frames=0,twist_frames=0,hold_frames=0,release_frames=0}]",
)  # fmt: skip
OPTIONS = WorkerOptions(workers=1)


@pytest.fixture(scope="module")
def recipe():
    return load_recipe("distil", SMALL)


def test_every_eighth_example_is_for_judging():
    assert [number for number in range(20) if is_held_out(number)] == [7, 15]


def test_an_example_holds_changes_and_fields_of_its_touches(recipe):
    task = ExampleTask(number=0, episode=draw_episodes(recipe)[0], images=2)
    example = Example.read(render_example(task))
    touches = len(example.facts["touches"])
    assert touches == 2
    assert example.change.shape == (touches, 2, 64, 48, 3)
    depths = [touch["depth_mm"] for touch in example.facts["touches"]]
    assert depths == sorted(depths)
    fields, gate = example.fields(example.maker(), 1)
    assert (fields.shape, gate.shape) == ((76, 32, 24), (64, 48))
    # Two images of one touch show the same change and noise of their own; the true tier's frame shows the change too.
    first, second = example.change[1].astype(float)
    tier = example.tier[1].astype(float)
    shared = np.mean(first * second)
    assert shared > 0
    assert np.mean((first - second) ** 2) > 0
    assert np.mean(tier * second) == pytest.approx(shared, rel=0.5)


@pytest.mark.slow
def test_a_model_is_made_resumed_and_used(recipe, tmp_path):
    pytest.importorskip("torch")
    pytest.importorskip("onnx")
    out, work = tmp_path / "ball.touch", tmp_path / "examples"
    few = Training(steps=20, saved_every=10)
    summary = distil(recipe, out, work, options=OPTIONS, training=few)
    assert summary.failed == 0
    model = TouchModel.read(out)
    assert model.facts.touches == summary.touches == 16
    assert model.facts.versions == versions()
    assert {row.states for row in model.facts.errors} >= {"all", "object sphere", "room dark"}
    every = next(row for row in model.facts.errors if row.states == "all")
    assert 0 < every.error < 2 * every.change
    # The same folder, from the checkpoint or from the examples alone, makes the same file.
    first = out.read_bytes()
    with pytest.raises(OutputError, match="--resume goes on"):
        distil(recipe, out, work, options=OPTIONS, training=few)
    distil(recipe, out, work, options=OPTIONS, training=few, resume=True)
    assert out.read_bytes() == first
    (work / CHECKPOINT).unlink()
    (work / example_name(3)).unlink()
    distil(recipe, out, work, options=OPTIONS, training=few, resume=True)
    assert out.read_bytes() == first
    # Other steps, another start or more examples train anew: a checkpoint of the old ones serves none of them.
    for settings in (replace(few, steps=10), replace(few, start=model)):
        distil(recipe, out, work, options=OPTIONS, training=settings, resume=True)
        assert TouchModel.read(out).network != model.network
    distil(recipe, out, work, options=OPTIONS, training=replace(few, steps=0, start=model), resume=True)
    measured = TouchModel.read(out)
    assert (measured.network, measured.facts.errors) == (model.network, model.facts.errors)
    distil(recipe.model_copy(update={"episodes": 10}), out, work, options=OPTIONS, training=few, resume=True)
    assert TouchModel.read(out).facts.touches == 18
    assert TouchModel.read(out).network != model.network
    out.write_bytes(first)
    # A scene uses it, and its frames name the tier.
    scene = load_scene("pressed", ["render.tier=fast", f"render.model='{out}'", *SMALL[:6], "rig.room=dark"])
    sensor = Sensor.for_scene(scene)
    state = FrameState(gap_mm=-0.6, x_mm=0.0, y_mm=0.0, twist_deg=0.0, flashlight=False, light_x_mm=0.0)
    assert sensor.render(state, sensor.deform(state, sensor.rest))[1] == EMULATED
    assert json.loads(model.facts.model_dump_json())["schema_version"] == 1


def test_a_start_that_does_not_fit_is_one_line():
    pytest.importorskip("torch")
    pytest.importorskip("onnx")
    ours = TouchModel.read(preset_root() / MODELS / "mini-magictac.touch")
    start_from(build_network(76), ours)
    for network, model in ((build_network(76), replace(ours, network=ours.network[:5000])), (build_network(3), ours)):
        with pytest.raises(ConfigError, match=r"^start = 'mini-magictac' is not allowed: .* does not fit: .+$"):
            start_from(network, model)


def test_a_recipe_of_the_fast_tier_is_refused(tmp_path):
    pytest.importorskip("torch")
    pytest.importorskip("onnx")
    recipe = load_recipe("distil", [*SMALL, "render.tier=fast"])
    with pytest.raises(ConfigError, match=r"^render\.tier = 'fast' is not allowed: a model is distilled from true"):
        distil(recipe, tmp_path / "a.touch", tmp_path / "b", options=OPTIONS, training=Training())
    assert not (tmp_path / "b").exists()


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        (["design=gelsight-type"], r"^no model is made of this sensor: a face with a coat or a shape is none that"),
        (["contact.coupling=dry"], r"^no model is made of this sensor: contact\.coupling = 'dry'"),
        (["rig.camera.rows=63"], r"^no model is made of this sensor: an odd picture of 48 x 63 pixels"),
        (["episodes=7"], r"^episodes = 7 is not allowed: must be at least 8, of which one judges"),
    ],
)
def test_what_can_be_no_model_is_told_before_anything_is_rendered(tmp_path, settings, line):
    pytest.importorskip("torch")
    pytest.importorskip("onnx")
    with pytest.raises(ConfigError, match=line):
        distil(
            load_recipe("distil", [*SMALL, *settings]), tmp_path / "a.touch", tmp_path / "b", options=OPTIONS,
            training=Training(),
        )  # fmt: skip
    assert not (tmp_path / "b").exists()


def test_a_file_that_cannot_be_written_is_told_before_anything_is_rendered(recipe, tmp_path):
    pytest.importorskip("torch")
    pytest.importorskip("onnx")
    (tmp_path / "a.touch").mkdir()
    with pytest.raises(OutputError, match="is a folder; name a file"):
        distil(recipe, tmp_path / "a.touch", tmp_path / "b", options=OPTIONS, training=Training())
    assert not (tmp_path / "b").exists()


def test_errors_are_told_of_a_sensor_that_one_colour_lights():
    rig = "rig.strips=[{side='-x',radiance=[5.0,0.0,0.0]}]"
    task = ExampleTask(number=7, episode=draw_episodes(load_recipe("distil", [*SMALL, rig]))[7], images=2)
    example = render_example(task)
    scene = SceneConfig.model_validate(Example.read(example).facts["scene"])

    class Silent(TouchModel):
        def predict(self, fields):
            return np.zeros((64, 48, 3), np.float32)

    class One(Library):
        def read(self, number):
            return Example.read(example)

    shipped = TouchModel.read(preset_root() / MODELS / "mini-magictac.touch")
    model = Silent(facts=shipped.facts, network=b"", rest=shipped.rest)
    every = measure(model, One(paths=[Path("one")]))[0]
    assert scene.lit == (True, False, False)
    assert every.error == every.change > 0


def test_without_pytorch_one_line_says_what_to_install(recipe, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "torch", None)
    with pytest.raises(ConfigError, match=r"pip install 'magicsim\[distil\]'"):
        distil(recipe, tmp_path / "a.touch", tmp_path / "b", options=OPTIONS, training=Training())
    assert not (tmp_path / "b").exists()
