"""The fast tier of a sensor: what is emulated, what is rendered, and what is refused in one line."""

import io
import re
import zipfile
from dataclasses import replace
from functools import partial

import numpy as np
import pyarrow.parquet as pq
import pytest

from magicsim.camera.exposure import meter
from magicsim.config.named_files import config_digest
from magicsim.dataset.card import tier_sentence
from magicsim.dataset.generate import generate_dataset
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.dataset.rows import simulate_sample
from magicsim.dataset.verify import verify_dataset
from magicsim.deform.lattice.structure import build_lattice
from magicsim.emulator.emulator import EMULATED, OFF, Emulator, known_model
from magicsim.emulator.fields import FieldMaker
from magicsim.emulator.model import ErrorRow, TouchModel, find_model
from magicsim.errors import ConfigError, RenderError
from magicsim.light.backend import dr
from magicsim.light.records.untouched import UntouchedStates
from magicsim.robot import LiveSensor
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState, TierError
from magicsim.simulation.emulation import CHECK_SEED, COMPRESSED, before_contact
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor
from magicsim.workers.attempt import Failure, FailureKind, Outcome, Work

from .sensors import COLOUR, SMALL, small_model, small_scene


def at(gap_mm: float, **changed: object) -> FrameState:
    state = {"gap_mm": gap_mm, "x_mm": 0.0, "y_mm": 0.0, "twist_deg": 0.0, "flashlight": False, "light_x_mm": 0.0}
    return FrameState(**(state | changed))


@pytest.fixture(scope="module")
def states() -> UntouchedStates:
    """The untouched sensor, which is one for all tests."""
    return UntouchedStates()


@pytest.fixture(scope="module")
def true(states) -> Sensor:
    return Sensor.for_scene(small_scene(), untouched=states)


@pytest.fixture(scope="module")
def rest(true):
    return true.radiance(UNTOUCHED, true.rest)


@pytest.fixture
def fast(states, rest, tmp_path):
    """Makes the sensor with a model that a test changes."""

    def make(*settings: str, **changed: object) -> Sensor:
        path = tmp_path / "made-up.touch"
        path.write_bytes(small_model(small_scene(), rest, **changed).to_bytes())
        scene = small_scene("render.tier=fast", f"render.model='{path}'", *settings)
        return Sensor.for_scene(scene, untouched=states)

    return make


@pytest.fixture(scope="module")
def pressed(true):
    return true.deform(at(-1.0), true.rest)


def test_a_touch_is_the_frame_before_contact_and_what_the_network_says(fast, rest, pressed):
    sensor = fast()
    image, origin = sensor.render(at(-1.0), pressed)
    assert origin == EMULATED
    before = sensor.radiance(before_contact(at(-1.0)), sensor.rest)
    change = (image - before) / rest.mean()
    middle, corner = change[28:36, 20:28].mean((0, 1)), change[:6, :6].mean((0, 1))
    np.testing.assert_allclose(middle, COLOUR, rtol=0.1)  # the gate is nearly open there
    np.testing.assert_allclose(corner, 0, atol=1e-6)


def test_what_is_near_comes_by_compressed_transport_and_nothing_else_does(fast, true, rest):
    sensor = fast()
    for state in (at(0.5), at(0.5, flashlight=True), at(None, flashlight=True)):
        image, origin = sensor.render(state, sensor.rest)
        assert origin == COMPRESSED
        change = true.radiance(state, true.rest) - rest
        assert np.abs((image - rest - change).mean((0, 1))).max() < 0.1 * np.abs(change.mean((0, 1))).max()
    image, origin = sensor.render(UNTOUCHED, sensor.rest)
    assert origin not in (EMULATED, COMPRESSED)
    np.testing.assert_array_equal(image, true.radiance(UNTOUCHED, true.rest))


def test_without_a_model_what_is_near_is_rendered_or_refused_as_its_touches_are(fast, true, caplog):
    sensor = fast("object.specular=0.5")
    assert sensor.render(at(0.5), sensor.rest)[1] != COMPRESSED
    assert "object.specular = 0.5 is more than" in caplog.text
    sensor = fast("object.specular=0.5", "render.outside_domain=refuse")
    with pytest.raises(ConfigError, match=r"tier = 'fast' is not allowed here: object\.specular = 0\.5"):
        sensor.render(at(0.5), sensor.rest)


def test_a_plan_says_which_passes_a_model_leaves_out_and_why_none_does(rest, tmp_path):
    path, stage = tmp_path / "made-up.touch", "both passes, of touches and of what is near"
    path.write_bytes(small_model(small_scene(), rest, errors=[row(0.5)]).to_bytes())
    fast = ("render.tier=fast", f"render.model='{path}'")
    left_out = {each.stage: each.reason for each in plan_scene(small_scene(*fast)).left_out}
    assert left_out[stage].startswith("touches by the model 'made up', 0.5 grey levels off")
    kept = {each.stage: each.reason for each in plan_scene(small_scene(*fast, "design.skin_mm=0.7")).kept}
    assert kept[stage].startswith("rendered: design.skin_mm = 0.7 is not what the model 'made up' knows")
    dry = {
        each.stage: each.reason
        for each in plan_scene(small_scene(*fast, "contact.coupling=dry", "render.outside_domain=refuse")).kept
    }
    assert dry[stage].startswith("refused (render.outside_domain): contact.coupling = 'dry'")
    assert stage not in str(plan_scene(small_scene()))


def test_the_word_true_needs_no_quotes():
    scene = small_scene("render.tier=true", "render.outside_domain=true")
    assert (scene.render.tier, scene.render.outside_domain) == ("true", "true")
    with pytest.raises(ConfigError, match="tier = False is not allowed"):
        small_scene("render.tier=false")


def test_true_is_what_the_tier_is_where_nobody_asks(true, pressed):
    assert true.render(at(-1.0), pressed)[1].image == "traced"


def test_fields_of_a_unit_are_made_once_but_for_a_lens_that_blurs_otherwise(fast):
    def fields(*settings: str):
        sensor = fast("render.outside_domain=true", *settings)
        sensor.render(at(2.0), sensor.rest)
        return sensor.emulation.emulator.fields, sensor.radiance(UNTOUCHED, sensor.rest)

    one, _ = fields()
    other, image = fields("rig.camera.blur_px=0.9")
    assert fields()[0] is one
    assert other is not one
    np.testing.assert_array_equal(other.rest, image)


def emulator_of(path, model: TouchModel, rest, *settings: str) -> Emulator | str:
    path.write_bytes(model.to_bytes())
    scene = small_scene(f"render.model='{path}'", *settings)
    known = known_model(scene.design, scene.rig, scene.object, scene.contact, scene.render)
    if isinstance(known, str):
        return known
    fields = partial(FieldMaker.of, scene.design, scene.rig, build_lattice(scene.design).nodes_mm, rest)
    return Emulator.of(known, scene.design, scene.rig, rest, fields)


@pytest.mark.parametrize(
    ("state", "line"),
    [
        (at(-2.0), "a touch 2 mm deep is deeper than the 1.5 mm"),
        (at(-1.0, flashlight=True), "under a flashlight"),
        (at(-1.0, facing_mm=30.0), "before another finger"),
        (at(-1.0), None),
    ],
)
def test_touches_that_the_model_does_not_know_are_told(rest, tmp_path, state, line):
    problem = emulator_of(tmp_path / "a.touch", small_model(small_scene(), rest), rest).refusal(state)
    assert problem is None if line is None else line in problem


@pytest.mark.parametrize(
    ("setting", "line"),
    [
        ("design.skin_mm=0.7", "design.skin_mm = 0.7 is not what the model 'made up' knows (0.8 to 0.8)"),
        ("rig.camera.columns=32", "camera.columns = 32"),
        ("object.specular=0.4", "object.specular = 0.4 is more than the 0 that its model knows"),
        ("object={kind='dots',radius_mm=0.2,spacing_mm=0.9}", "object.spacing_mm = 0.9 is finer than the 1"),
        ("rig.camera.blur_px=1.1", "a blur of 1.1 px by camera.blur_px and camera.diffraction is not what the model"),
        ("rig.camera.blur_px=0.3", "is not what the model 'made up' knows (0.4 to 1)"),
        ("rig.camera.diffraction={f_number=20}", "a blur of 1.5 px"),
        ("rig.camera.rows=63", "an odd picture of 48 x 63 pixels is none that a model knows"),
    ],
)
def test_another_sensor_or_object_is_told_by_its_field(rest, tmp_path, setting, line):
    found = emulator_of(tmp_path / "a.touch", small_model(small_scene(), rest), rest, setting)
    assert isinstance(found, str)
    assert line in found


def test_a_model_that_learned_from_no_texture_knows_none(rest, tmp_path):
    model = small_model(small_scene(), rest, spacing_mm=0.0)
    found = emulator_of(tmp_path / "a.touch", model, rest, "object={kind='dots',radius_mm=0.2,spacing_mm=3.0}")
    assert found == "object.spacing_mm = 3 is not known: its model learned from no texture"
    assert isinstance(emulator_of(tmp_path / "a.touch", model, rest), Emulator)


def test_a_lens_that_hardly_blurs_otherwise_is_known(rest, tmp_path):
    for setting in ("rig.camera.blur_px=0.9", "rig.camera.blur_px=0.5", "rig.camera.diffraction={f_number=2.8}"):
        assert isinstance(emulator_of(tmp_path / "a.touch", small_model(small_scene(), rest), rest, setting), Emulator)


@pytest.mark.parametrize(("skin_mm", "known"), [(0.765, True), (0.83, True), (0.85, False), (0.75, False)])
def test_a_unit_may_lie_a_little_beside_those_that_the_model_learned_from(rest, tmp_path, skin_mm, known):
    model = small_model(small_scene(), rest)
    facts = model.facts.model_copy(update={"sensor": model.facts.sensor | {"design.skin_mm": (0.78, 0.82)}})
    found = emulator_of(tmp_path / "a.touch", replace(model, facts=facts), rest, f"design.skin_mm={skin_mm}")
    assert isinstance(found, Emulator) == known
    assert known or "(0.76 to 0.84)" in str(found)


def test_the_number_of_a_random_print_is_none_of_what_a_model_asks_for(rest, tmp_path):
    found = emulator_of(tmp_path / "a.touch", small_model(small_scene(), rest), rest, "design.unevenness.seed=7")
    assert isinstance(found, Emulator)


def test_what_the_models_that_come_with_the_program_do_not_know_is_told():
    scene = load_scene("pressed", ["design.cell_mm=1.0"])
    model, reason = find_model(None, scene.design, scene.rig)
    assert model is None
    assert re.match(r"design\.cell_mm = 1\.0 is not what the model '.*' knows \(0\.7\d* to 0\.8\d*\)", reason)


def test_an_untouched_image_that_code_has_changed_is_told(rest, tmp_path):
    model = small_model(small_scene(), rest * np.linspace(0.9, 1.1, rest.shape[1])[:, None])
    found = emulator_of(tmp_path / "older.touch", model, rest)
    assert isinstance(found, str)
    assert re.match(r"the untouched image differs by \d\.\d% ", found)


def test_what_is_not_known_is_rendered_with_a_line_or_refused(fast, pressed, caplog):
    deep = {"depth_mm": 0.5}
    assert fast(**deep).render(at(-1.0), pressed)[1] != EMULATED
    line = "a touch 1 mm deep is deeper than the 0.5 mm that its model knows"
    assert f"true frames in place of fast ones: {line}" in caplog.text
    with pytest.raises(ConfigError, match=rf"render\.tier = 'fast' is not allowed here: {line}"):
        fast('render.outside_domain="refuse"', **deep).render(at(-1.0), pressed)
    for setting, what in (
        ("contact.coupling=dry", r"contact\.coupling = 'dry'"),
        ("contact.infill_yield_mpa=0.1", "a material that relaxes or yields"),
        ("rig.camera.region_px=[8,8,16,16]", r"a picture with camera\.region_px or glare"),
        ("rig.camera.glare={share=0.1}", r"a picture with camera\.region_px or glare"),
    ):
        with pytest.raises(ConfigError, match=what):
            fast(setting, 'render.outside_domain="refuse"').render(at(-1.0), pressed)


def test_an_object_that_just_touches_the_face_is_shown_as_one_just_before_it(fast):
    sensor = fast('render.outside_domain="refuse"')
    for gap_mm in (0.0, 0.0005):
        assert sensor.render(at(gap_mm), sensor.rest)[1] == COMPRESSED


def test_stiffness_and_lattice_are_none_of_what_a_model_asks_for(rest, tmp_path):
    settings = (
        "design.materials.body.youngs_modulus_mpa=2.5",
        "design.lattice.growth=3.0",
        "design.limits.force_n=3.0",
    )
    found = emulator_of(tmp_path / "a.touch", small_model(small_scene(), rest), rest, *settings)
    assert isinstance(found, Emulator)


def test_a_live_sensor_of_control_quality_emulates_its_touches(true, rest, tmp_path):
    path = tmp_path / "made-up.touch"
    path.write_bytes(small_model(small_scene(), rest).to_bytes())
    settings = ("render.tier=fast", f"render.model='{path}'", "render.outside_domain=refuse")
    with LiveSensor(small_scene(*settings), quality="control", told=lambda _line: None) as sensor:
        sensor.move_to(gap_mm=-0.5)
        assert sensor.frame().origin == EMULATED


def test_a_damaged_or_missing_file_is_one_line(tmp_path, rest):
    path = tmp_path / "damaged.touch"
    path.write_bytes(small_model(small_scene(), rest).to_bytes()[:-300])
    with pytest.raises(ConfigError, match=r"damaged\.touch' is not a model of touches"):
        TouchModel.read(path)
    whole = small_model(small_scene(), rest).to_bytes()
    bent = bytearray(whole)
    start = whole.index(b"model.json") + len("model.json")
    bent[start : start + 40] = b"\xff" * 40  # the archive's list is whole, what it lists is not
    empty = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(whole)) as archive, zipfile.ZipFile(empty, "w") as other:
        for name in archive.namelist():
            other.writestr(name, b"" if name == "rest.npy" else archive.read(name))
    for content in (bytes(bent), empty.getvalue()):
        path.write_bytes(content)
        with pytest.raises(ConfigError, match=r"damaged\.touch' is not a model of touches"):
            TouchModel.read(path)
    with pytest.raises(ConfigError, match=r"none\.touch' cannot be read: No such file"):
        find_model(str(tmp_path / "none.touch"), small_scene().design, small_scene().rig)


def test_a_damaged_network_is_one_line(rest):
    model = replace(small_model(small_scene(), rest), network=b"none")
    with pytest.raises(ConfigError, match=r"the network of the model '.*' is damaged"):
        model.predict(np.zeros((76, 8, 8), np.float32))


def test_threads_do_not_change_what_the_model_of_the_default_sensor_says():
    scene, found, before = load_scene("pressed"), [], dr.thread_count()
    fields = np.random.default_rng(1).normal(size=(76, 24, 32)).astype(np.float32)
    try:
        for threads in (1, 2):
            dr.set_thread_count(threads)
            model = replace(find_model(None, scene.design, scene.rig)[0])
            found.append(model.predict(fields))
    finally:
        dr.set_thread_count(before)
    assert np.ptp(found[0]) > 0.1
    np.testing.assert_array_equal(*found)


def test_a_model_comes_back_from_its_file(tmp_path, rest):
    model = small_model(small_scene(), rest)
    path = tmp_path / "made-up.touch"
    path.write_bytes(model.to_bytes())
    again = TouchModel.read(path)
    assert (again.facts, again.network) == (model.facts, model.network)
    np.testing.assert_array_equal(again.rest, model.rest)
    assert model.to_bytes() == model.to_bytes()


def row(error: float) -> ErrorRow:
    return ErrorRow(states="all", touches=1, change=1.0, error=error, true_tier=0.0)


def test_a_frame_that_is_checked_tells_how_far_it_is_off(fast, true, rest, pressed):
    sensor = fast(errors=[row(100.0)])
    sensor.emulation.checked_share = 1.0
    image, origin = sensor.render(at(-1.0), pressed)
    gain = 255 * meter(rest, sensor.rig.camera, sensor.lit)
    careful = true.renderer.reseeded(seed=CHECK_SEED).radiance(true.view(at(-1.0), pressed))
    off = np.abs(gain * (image.astype(float) - careful))
    assert origin.error.mean == pytest.approx(off.mean(), rel=1e-6)
    assert origin.error.p99 == pytest.approx(np.percentile(off, 99), rel=1e-6)
    assert origin.error.mean < origin.error.p95 < origin.error.p99


def test_a_frame_that_is_too_far_off_is_an_error(fast, pressed):
    sensor = fast(errors=[row(0.01)])
    sensor.emulation.checked_share = 1.0
    with pytest.raises(RenderError, match=rf"{OFF} .* grey levels in a touch, at most 0.03 is allowed"):
        sensor.render(at(-1.0), pressed)


def test_the_card_of_a_dataset_says_how_far_its_frames_are_off():
    sentence = tier_sentence(30, 40, [TierError(0.5, 2.0, 4.0), TierError(0.7, 3.0, 6.0)])
    assert sentence.startswith("30 of 40 pictures of touches are emulated, all others true")
    assert "2 of the emulated ones" in sentence
    assert "0.60 linear grey levels in the mean, 95 % of values by less than 2.5, 99 % by less than 5.0" in sentence
    assert "None of them" in tier_sentence(0, 3, [])


@pytest.mark.slow
def test_a_dataset_of_emulated_touches_names_them_and_stops_where_they_are_wrong(rest, tmp_path, monkeypatch):
    path = tmp_path / "made-up.touch"
    press = "paths=[{kind='touch',gap_mm=0.5,depth_mm=1.0,approach_frames=1,press_frames=1,shear_frames=0,"
    settings = [
        *(each for each in SMALL if "references" not in each), "episodes=1", "rooms=[]", "tolerances={}", "camera={}",
        "objects=[{kind='sphere',radius_mm=5.0}]", press + "twist_frames=0,hold_frames=0,release_frames=0}]",
        "rig=digit-office", "rig.room=dark", "render.tier=fast", f"render.model='{path}'",
    ]  # fmt: skip
    monkeypatch.setattr("magicsim.dataset.rows.CHECKED_SHARE", 1.0)
    for error in (100.0, 0.001):
        path.write_bytes(small_model(small_scene(), rest, errors=[row(error)]).to_bytes())
        recipe = load_recipe("default", settings)
        simulator = Work(function=simulate_sample, prepare=None)
        monkeypatch.setattr("magicsim.dataset.generate.run_tasks", here)
        out = tmp_path / f"{error:g}"
        if error < 1:
            for resume in (False, True, True):  # an episode that stopped the run is not done with
                with pytest.raises(RenderError, match=f"episode 0: {OFF}"):
                    generate_dataset(recipe, out, simulator=simulator, resume=resume)
            break
        generate_dataset(recipe, out, simulator=simulator)
        rows = [each for file in (out / "data").glob("*.parquet") for each in pq.read_table(file).to_pylist()]
        touched = [each for each in rows if each["contact"]]
        assert touched
        assert {each["image_way"] for each in touched} == {"emulated"}
        assert all(each["tier_mean"] > 0 for each in touched)
        assert all(np.isnan(each["tier_mean"]) for each in rows if not each["contact"])
        card = (out / "README.md").read_text()
        assert f"{len(touched)} of {len(touched)} pictures of touches are emulated" in card
        assert f"{len(touched)} of the emulated ones, drawn at random" in card
        assert verify_dataset(out).problems == []


def here(function, tasks, _options, *, prepare=None):
    """Runs tasks in this process."""
    for key, task in tasks:
        try:
            yield Outcome(key=key, result=function(task), failures=(), seconds=0.0)
        except RenderError as error:
            yield Outcome(
                key=key, result=None, failures=(Failure(kind=FailureKind.REFUSED, message=str(error)),), seconds=0.0
            )


def test_another_model_under_the_same_name_is_another_configuration(rest, tmp_path):
    path, digests = tmp_path / "a.touch", []
    for depth in (1.0, 2.0):
        path.write_bytes(small_model(small_scene(), rest, depth_mm=depth).to_bytes())
        scene = small_scene("render.tier=fast", f"render.model='{path}'")
        digests.append(config_digest(scene.model_dump(mode="json")))
    assert digests[0] != digests[1]
    with pytest.raises(ConfigError, match=r"model = 'a\.zip' is not allowed: must end with \.touch"):
        small_scene("render.model=a.zip")
