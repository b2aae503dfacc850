"""Untouched sensors on disk: same bytes with and without, several writers, nothing lost, nothing broken believed."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from magicsim.light.backend import VARIANT
from magicsim.light.near.near_views import NearViews
from magicsim.light.records.untouched import (
    UntouchedStates,
    UntouchedStore,
    arrays_of,
    default_store,
    untouched_of,
)
from magicsim.scenes.scene import load_scene
from magicsim.simulation.sensor import Sensor

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
SMALL = [
    "design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "rig.camera.columns=24", "rig.camera.rows=28",
    "object.radius_mm=3", "render.anchor_samples=2", "render.anchor_particles=2000", "render.particles=500",
]  # fmt: skip


def sensor(store):
    return Sensor.for_scene(load_scene("near", SMALL, seed=1), untouched=UntouchedStates(store))


def image(store):
    made = sensor(store)
    return made.radiance(made.states[0], made.rest)


@pytest.fixture
def store(tmp_path):
    return UntouchedStore(folder=tmp_path / "kept")


def test_frames_are_the_same_with_and_without(store, monkeypatch):
    alone = image(None)
    np.testing.assert_array_equal(image(store), alone)
    assert len(store.files()) == 1
    read = image(store)
    np.testing.assert_array_equal(read, alone)


def test_a_kept_sensor_is_not_rendered_again(store, monkeypatch):
    image(store)
    kept = sensor(store)
    monkeypatch.setattr("magicsim.light.rest_renderer.untouched", lambda *_, **__: pytest.fail("rendered again"))
    assert kept.renderer.anchor().image.shape == (28, 24, 3)


def test_light_through_the_face_is_followed_once(store, monkeypatch):
    def near(store):
        made = sensor(store)
        return NearViews(made.renderer).radiance(made.view(made.states[0], made.rest))

    alone = near(None)
    assert alone is not None
    np.testing.assert_array_equal(near(store), alone)
    monkeypatch.setattr("magicsim.light.near.near_views.follow_ports", lambda _: pytest.fail("followed again"))
    np.testing.assert_array_equal(near(store), alone)


@pytest.mark.parametrize(
    "spoil", [lambda data: b"", lambda data: data[:-100], lambda data: data[:900] + b"!" + data[901:]]
)
def test_what_cannot_be_read_is_computed_anew(store, spoil, caplog):
    alone = image(store)
    (path,) = store.files()
    path.write_bytes(spoil(path.read_bytes()))
    np.testing.assert_array_equal(image(store), alone)
    assert "computed anew" in caplog.text


def test_several_writers_leave_one_whole_file(store):
    made = sensor(store)
    state = made.renderer.anchor()
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda _: store.save("key", arrays_of(state)), range(12)))
    assert len(store.files()) == 2
    np.testing.assert_array_equal(store.load("key", untouched_of).image, state.image)


def test_the_oldest_go_and_foreign_files_stay(store):
    state = sensor(None).renderer.anchor()
    store.save("first", arrays_of(state))
    foreign = [store.folder / name for name in ("notes.txt", "magicsim-untouched-mine.npz")]
    for path in foreign:
        path.write_text("mine")
    store = UntouchedStore(folder=store.folder, most_bytes=int(1.5 * store.size_bytes()))
    store.save("second", arrays_of(state))
    assert store.load("first", untouched_of) is None
    assert store.load("second", untouched_of) is not None
    assert store.clear() == 1
    assert [path.read_text() for path in foreign] == ["mine", "mine"]


def test_a_folder_that_cannot_be_written_is_none(tmp_path, caplog):
    (tmp_path / "file").write_text("")
    blocked = UntouchedStore(folder=tmp_path / "file" / "kept")
    np.testing.assert_array_equal(image(blocked), image(None))
    assert caplog.text.count("nothing is kept") == len(caplog.records) == 1


def test_the_folder_is_chosen_by_the_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("MAGICSIM_CACHE", "off")
    assert default_store() is None
    monkeypatch.setenv("MAGICSIM_CACHE", str(tmp_path))
    assert default_store().folder == tmp_path
    monkeypatch.delenv("MAGICSIM_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert default_store().folder == tmp_path / "cache" / "magicsim"
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("MAGICSIM_CACHE", "~/mine")
    assert default_store().folder == tmp_path / "mine"
