"""A film of a design in a room in which somebody passes."""

import numpy as np
import pytest

from magicsim.light.records.untouched import UntouchedStates
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor
from magicsim.sweep.designs import SweptSensor, camera_of, list_designs, render_of, renderings_of
from magicsim.sweep.film import PASSED, DesignFilm, film_design
from magicsim.sweep.sweep_file import SweepConfig
from sweep.fakes import small_sweep

pytestmark = pytest.mark.slow
SETTINGS = (
    "rig=digit-office", "design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "quality.columns=24", "quality.rows=32",
    "quality.touches=6", "quality.gaps_mm=[20.0,5.0,1.0]", "quality.depths_mm=[0.3,1.0]",
    "object.radius_mm=3", "quality.contact_depths_mm=[0.05,0.6]",
)  # fmt: skip
SWEPT = ("quality.renderings=1", "swept=[{field='rig.room',values=['office','corridor']}]")


def seen_by(sensor: SweptSensor, sweep: SweepConfig) -> list[SweptSensor]:
    return [each.sensor for each in renderings_of(sensor, sweep)]


@pytest.fixture(scope="module")
def films() -> list[DesignFilm]:
    sweep = small_sweep(*SETTINGS, *SWEPT)
    return [
        film_design([each.sensor], sweep.object, sweep.quality, seed=1, untouched=UntouchedStates())[0]
        for each in list_designs(sweep)
    ]


def test_untouched_frames_show_what_passes_at_several_places_of_its_way(films: list[DesignFilm]):
    office, corridor = films
    assert office.untouched.at_other_times == ()
    assert len(corridor.untouched.at_other_times) == PASSED
    shown = [corridor.untouched.radiance, *corridor.untouched.at_other_times]
    assert len({each.tobytes() for each in shown}) == PASSED + 1


def test_noise_and_strength_of_a_still_room_are_drawn_as_without_anything_that_passes(films: list[DesignFilm]):
    office, _ = films
    first, more = office.frames(office.untouched, 2, drift=0.1), office.frames(office.untouched, 3, drift=0.1)
    assert all((one == other).all() for one, other in zip(first, more[:2], strict=True))
    assert (more[0] != more[1]).any()


def test_contact_is_told_at_further_depths_too(films: list[DesignFilm]):
    assert [[each.gap_mm for each in depth] for depth in films[0].others] == [[-0.05] * 6, [-0.6] * 6]
    assert [(each.x_mm, each.y_mm) for each in films[0].others[1]] == [
        (each.x_mm, each.y_mm) for each in films[0].light_touches
    ]


def test_states_of_the_film_see_it_move(films: list[DesignFilm]):
    office, corridor = films
    changes = [np.abs(one.radiance - other.radiance).mean() for one, other in zip(
        corridor.approach, office.approach, strict=True
    )]  # fmt: skip
    assert min(changes) > 0


def test_renderings_stand_in_rooms_of_their_own_and_have_cameras_of_their_own():
    sweep = small_sweep(*SETTINGS, "quality.renderings=3", "rooms=['window','dark']")
    sensor = list_designs(sweep)[0].sensor
    films = film_design(seen_by(sensor, sweep), sweep.object, sweep.quality, seed=1, untouched=UntouchedStates())
    window, dark, again = (film.untouched.radiance.mean((0, 1)) for film in films)
    np.testing.assert_allclose(window, again, rtol=0.05)
    assert (dark < 0.99 * window).all()
    assert len({film.camera.pattern_seed for film in films}) == 3
    assert (films[1].gain > films[0].gain).all()
    touched = [film.touches[0].radiance for film in films]
    assert all(np.abs(one - film.untouched.radiance).max() > 0 for one, film in zip(touched, films, strict=True))


def test_another_print_on_shared_meshes_is_seen_as_one_built_anew():
    draws = ("tolerances.led_strength={low=0.5,high=0.9}", "tolerances.skin_roughness={low=0.05,high=0.2}")
    sweep = small_sweep(*SETTINGS, *draws, "tolerances.flakes_per_mm3=2.0", "quality.renderings=2")
    one, other = seen_by(list_designs(sweep)[0].sensor, sweep)
    render = render_of(one, sweep.quality)
    rigs = [each.rig.model_copy(update={"camera": camera_of(each, sweep.quality)}) for each in (one, other)]
    first = Sensor(one.design, rigs[0], render=render, seed=1)
    shared = first.reseeded(1).with_rig(rigs[1], design=other.design)
    anew = Sensor(
        other.design, rigs[1], render=render.model_copy(update={"anchor_seed": render.anchor_seed + 1}), seed=2
    )
    seen = [each.radiance(UNTOUCHED, each.rest) for each in (first, shared, anew)]
    assert (seen[1] == seen[2]).all()
    assert (np.abs(seen[1].mean((0, 1)) / seen[0].mean((0, 1)) - 1) > 0.05).all()
