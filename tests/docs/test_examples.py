"""The gallery's scripts and the tutorial's files, run with small settings."""

import numpy as np
import pytest

import magicsim
from magicsim import load_design, load_scene, simulate
from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.detectors import Contact
from magicsim.evaluation.detector import Detector, find_detector
from magicsim.geometry.shapes.solids import Sphere
from magicsim.scenes.scene import SceneConfig
from magicsim.simulation.sensor import Sensor

from .pages import EXAMPLES, load

SMALL_BLOCK = ["footprint_mm=[12,12]", "lattice.cells_across=0"]
SMALL_RENDERING = [
    "design.footprint_mm=[12,16]", "rig.camera.columns=24", "rig.camera.rows=32", "rig.camera.field_mm=10",
    "design.lattice.cells_across=0",
    "render.samples=2", "render.particles=4000",
]  # fmt: skip
SMALL_SENSOR = [
    "design.lattice.spacing_mm=2", "rig.camera.columns=30", "rig.camera.rows=36", "render.samples=8", "references=3",
    "design.lattice.cells_across=0",
    "render.particles=4000", "render.anchor_samples=8", "render.anchor_particles=8000",
]  # fmt: skip


def test_force_curve():
    [force] = load(EXAMPLES / "force_curve.py").forces_n((1.0,), spacing_mm=1.0)
    assert force == pytest.approx(5.065, rel=0.01)  # finite elements, see README


def test_skin_and_core():
    script = load(EXAMPLES / "skin_and_core.py")
    default, skin, core = (
        script.force_n([*SMALL_BLOCK, "lattice.spacing_mm=2", *changes]) for changes in script.DESIGNS.values()
    )
    assert core < default < skin
    assert 1.05 < skin / default < 1.4  # 1.17 on the whole block at full resolution


def test_relaxation():
    moments = load(EXAMPLES / "relaxation.py").history(
        [*SMALL_BLOCK, "lattice.spacing_mm=2"], speed_mm_s=10.0, hold_s=0.1
    )
    forces = [moment.force_n[2] for moment in moments]
    peak = forces.index(max(forces))
    assert moments[peak].time_s == pytest.approx(0.05)
    assert all(later < earlier for earlier, later in zip(forces[peak:], forces[peak + 1 :], strict=False))
    assert forces[-1] < 0.8 * forces[peak]


def test_left_out():
    assert load(EXAMPLES / "left_out.py").counts("demo") == (74, 16, 37)


def test_print_volume(tmp_path):
    done = load(EXAMPLES / "print_volume.py").export(tmp_path / "block.3mf", SMALL_BLOCK)
    assert done.volume_mm3 + done.infill_volume_mm3 == pytest.approx(12 * 12 * 6.6)


def test_dim_a_light():
    before, after = load(EXAMPLES / "dim_a_light.py").images([*SMALL_RENDERING, "rig.room='dark'"])
    assert after[..., 0] == pytest.approx(before[..., 0] / 2, rel=1e-5)  # the first strip alone is red
    assert after[..., 1] == pytest.approx(before[..., 1], rel=1e-5)
    assert (after[..., 2] == 0).all()


def test_your_detector():
    detector = load(EXAMPLES / "your_detector.py").LargestChange()
    assert isinstance(detector, Detector)
    detector.fit([np.full((32, 24, 3), 90, np.uint8)] * 3)
    frame = np.full((32, 24, 3), 92, np.uint8)
    assert detector.change(frame) == pytest.approx(2)
    assert detector.step(frame).contact == "Untouched"
    frame[10:20, 10:20] = 130
    assert detector.step(frame).contact == "Touched"
    assert find_detector(f"{EXAMPLES / 'your_detector.py'}:LargestChange")().threshold == detector.threshold


@pytest.mark.slow
def test_your_detector_beside_the_calibrated_one():
    script = load(EXAMPLES / "your_detector.py")
    episode = simulate(load_scene("demo", ["rig.camera.columns=120", "rig.camera.rows=160"]))
    assert 0.5 < script.contact_accuracy(episode, script.LargestChange) <= 1


def test_own_object():
    script = load(EXAMPLES / "own_object.py")
    capsule, ball = script.Capsule(2.0, 6.0), Sphere(2.0)
    points = np.random.default_rng(1).uniform(-6, 6, (200, 3))
    distance, normal = capsule.distance(points)
    step = 1e-5
    moved, _ = capsule.distance(points + step * normal)
    assert moved - distance == pytest.approx(np.full(200, step), rel=1e-6)
    vertices = capsule.mesh().vertices
    assert np.abs(capsule.distance(vertices)[0]).max() < 1e-5
    assert capsule.support_mm(np.array([0.0, 1.0, 0.0])) == pytest.approx(vertices[:, 1].max(), abs=1e-5)
    assert script.Capsule(2.0, 0.0).distance(points)[0] == pytest.approx(ball.distance(points)[0])
    short, longer = (script.force_n(length, [*SMALL_BLOCK, "lattice.spacing_mm=2"]) for length in (0.1, 4.0))
    assert longer > 1.3 * short


def test_own_material():
    script = load(EXAMPLES / "own_material.py")
    coarse = [*SMALL_BLOCK, "lattice.spacing_mm=2"]
    once, twice = script.force_n(coarse), script.force_n([*coarse, *script.scaled(2.0)])
    assert twice / once == pytest.approx(2, rel=2e-3)  # the same equilibrium under twice the stress


def test_own_measure():
    script = load(EXAMPLES / "own_measure.py")
    found = script.measured("cell-skin", [])
    assert len(found) > 1
    assert all(0 < each.value < 1 for _, each in found)
    thin, thick = (script.infill_share(load_design("mini-magictac", [f"wall_mm={wall}"])) for wall in (0.1, 0.3))
    assert thick.value < thin.value
    assert script.infill_share(load_design("uniform-block")).value == 0


def test_own_estimator():
    distances = load(EXAMPLES / "own_estimator.py").distances_mm(SMALL_RENDERING)
    lens = load_scene("rest", SMALL_RENDERING).rig.camera.distance_mm
    assert distances.min() == pytest.approx(lens - 0.1, abs=1e-2)  # straight ahead to the lens's face


@pytest.fixture(scope="module")
def own_sensor() -> SceneConfig:
    return load_scene(EXAMPLES / "own-sensor" / "press.toml")


def test_own_sensor_is_what_the_tutorial_says(own_sensor: SceneConfig):
    assert own_sensor.design.footprint_mm == (18, 22)
    assert not own_sensor.design.has_grid
    assert [strip.side for strip in own_sensor.rig.strips] == ["-x", "+x", "+y"]
    assert Sensor.for_scene(own_sensor).renderer.estimator == "fluence"


def test_own_recipe_draws_the_same_sensor(own_sensor: SceneConfig):
    recipe = load_recipe(EXAMPLES / "own-sensor" / "touches.toml")
    assert (recipe.design, recipe.rig) == (own_sensor.design, own_sensor.rig)
    drawn = draw_episodes(recipe)
    assert {each.path_kind for each in drawn} == {"touch", "hover"}
    assert {each.scene.object.kind for each in drawn} == {"cylinder", "sphere"}


def test_own_sensor_ends_in_frames_and_forces():
    episode = load(EXAMPLES / "own_sensor.py").run(SMALL_SENSOR)
    assert len(episode.references) == 3
    assert len(episode.scored) == 8
    near, pressed, slid = (episode.scored[number] for number in (0, 3, 5))
    assert near.truth.force_n == (0, 0, 0)
    assert pressed.truth.depth_mm == pytest.approx(0.8)
    assert pressed.truth.force_n[2] > 0.5
    assert slid.truth.force_n[0] > 0.1  # friction drags the skin along
    # what touches is in optical contact: brighter than the same place before
    touched = pressed.contact_mask
    assert pressed.image[touched].mean() > 1.3 * episode.references[0].image[touched].mean()
    # red from -x, where columns are small; green from +x
    half = near.image.shape[1] // 2
    at_rest = episode.references[0].image.astype(float)
    assert at_rest[:, :half, 0].mean() > 1.2 * at_rest[:, half:, 0].mean()
    assert at_rest[:, half:, 1].mean() > 1.2 * at_rest[:, :half, 1].mean()


SMALL_DOME = [
    "design.lattice.spacing_mm=2", "rig.camera.columns=20", "rig.camera.rows=26", "render.samples=64",
    "design.lattice.cells_across=0",
    "render.anchor_samples=256", "references=3",
]  # fmt: skip


@pytest.fixture(scope="module")
def domed_sensor():
    return load(EXAMPLES / "domed_sensor.py")


def test_domed_sensor_is_what_caliper_and_photo_say(domed_sensor):
    design = load_design(EXAMPLES / "domed-sensor" / "block.toml")
    assert design.height_mm == pytest.approx(7.0)
    assert design.face.radius_x_mm == pytest.approx(domed_sensor.radius_mm(20.0, 1.25), abs=0.05)
    assert design.face.radius_y_mm == pytest.approx(domed_sensor.radius_mm(26.0, 1.40), abs=0.05)
    assert list(design.coat.color) == domed_sensor.reflectance((120, 120, 122), (202, 203, 201))
    edges = design.face.rise_mm(np.array([[10.0, 0.0], [0.0, 13.0], [10.0, 13.0]]))
    assert edges == pytest.approx([1.25, 1.40, 2.6], abs=0.01)  # the readings


def test_reflectance_undoes_the_tone_curve(domed_sensor):
    assert domed_sensor.reflectance((255, 255, 255), (255, 255, 255), 0.8) == [0.8, 0.8, 0.8]
    assert domed_sensor.reflectance((188, 188, 188), (255, 255, 255), 1.0) == pytest.approx([0.5] * 3, abs=0.01)


def test_recipe_of_the_domed_sensor_draws_that_sensor():
    recipe = load_recipe(EXAMPLES / "domed-sensor" / "touches.toml")
    scene = load_scene(EXAMPLES / "domed-sensor" / "press.toml")
    assert (recipe.design, recipe.rig) == (scene.design, scene.rig)
    assert {each.scene.object.kind for each in draw_episodes(recipe)} == {"sphere", "cylinder"}


@pytest.mark.slow
def test_domed_sensor_ends_in_labelled_frames(domed_sensor):
    episode = domed_sensor.run(SMALL_DOME)
    at_rest = np.mean([each.image for each in episode.references], 0)
    near, pressed, slid = (episode.scored[number] for number in (0, 3, 5))
    noise = np.abs(episode.references[0].image - at_rest).mean()
    assert near.truth.force_n == (0, 0, 0)
    assert np.abs(near.image - at_rest).mean() < 2 * noise + 0.1  # nothing outside is seen
    assert pressed.truth.depth_mm == pytest.approx(0.8)
    assert pressed.truth.force_n[2] > 0.5
    assert slid.truth.force_n[0] > pressed.truth.force_n[0] + 0.1  # friction drags the coat along
    columns = np.argwhere(pressed.contact_mask)[:, 1]
    assert columns.mean() > 10  # beside the crown, towards +x
    changed = np.abs(pressed.image - at_rest).mean(2)
    rows, columns = np.indices(changed.shape)
    around = np.hypot(columns - columns[pressed.contact_mask].mean(), rows - rows[pressed.contact_mask].mean()) < 5
    assert changed[around].mean() > 3 * changed[~around].mean()


TINY = [
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=2", "rig.camera.columns=24", "rig.camera.rows=32",
    "design.lattice.cells_across=0",
    "rig.camera.field_mm=10", "render.samples=2", "render.particles=2000", "render.anchor_samples=2",
    "render.anchor_particles=4000",
]  # fmt: skip


@pytest.fixture(scope="module")
def whole_api():
    return load(EXAMPLES / "whole_api.py")


def test_every_public_name_is_used_in_the_example():
    text = (EXAMPLES / "whole_api.py").read_text(encoding="utf-8")
    types = {name for name in magicsim.__all__ if name[0].isupper()} - {"Sensor"}
    older = {"evaluate_suite", "render_still", "relight"} | types  # taken by others, and what functions return
    assert {name for name in set(magicsim.__all__) - older if f"magicsim.{name}(" not in text} == set()


def test_whole_api_presses_prints_and_calibrates(whole_api, tmp_path):
    assert whole_api.press([*SMALL_BLOCK, "lattice.spacing_mm=2"]) > 0.5
    half, whole = whole_api.press_deeper_and_deeper([*SMALL_BLOCK, "lattice.spacing_mm=2"])
    assert 0 < half < whole
    weak = ["limits.elongation_at_break=[0.05,0.1]", "limits.tensile_strength_mpa=[0.1,0.2]"]
    assert 0 < whole_api.press_until_it_fails([*SMALL_BLOCK, *weak, "limits.infill_yield_mpa=[1e-4,2e-4]"]) < 1
    volume, scale = whole_api.print_and_calibrate(tmp_path, SMALL_BLOCK)
    assert 0 < volume < 12 * 12 * 6.6
    assert 0.01 < scale < 1


def test_whole_api_renders_and_films(whole_api):
    assert whole_api.render_and_film(TINY) == ((32, 24, 3),) * 3


@pytest.mark.slow
def test_whole_api_measures_hardness(whole_api):
    assert 10 < whole_api.harden(SMALL_BLOCK) < 60


@pytest.mark.slow
def test_whole_api_simulates_judges_detects_and_fits(whole_api, tmp_path):
    frames, _ = whole_api.simulate_and_judge(tmp_path, TINY)
    assert frames == 104
    assert np.load(tmp_path / "episode.npz")["images"].shape == (104, 32, 24, 3)
    contact, profile = whole_api.detect_and_fit(tmp_path, TINY)
    assert contact in list(Contact)
    assert profile.endswith("mine.toml")
    assert whole_api.fit_a_sensor(tmp_path, [*TINY, "rig.camera.columns=32", "rig.camera.rows=40"]) >= 0
