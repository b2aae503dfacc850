from pathlib import Path

import numpy as np
import pytest

from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.errors import ConfigError
from magicsim.geometry.design import load_design
from magicsim.scenes.rig import load_rig
from magicsim_experiments.study.learned.wear_settings import Drift, Pits, worn
from magicsim_experiments.study.study_file import load_study

from .made_study import made, rows, run

DESIGN, RIG = load_design("mini-magictac"), load_rig("digit-office")
DRIFTS = (
    Drift(name="thinner", added={"skin_mm": -0.2}),
    Drift(name="softer", factors={"materials.infill.shear_modulus_mpa": 0.5}),
    Drift(name="dimmer", strips=(0.5, 1.0, 1.0, 0.8)),
    Drift(name="pits", pits=Pits(per_mm2=0.5)),
)


def test_new_sensor_is_the_sensor_and_wear_grows_in_proportion():
    assert worn(DESIGN, RIG, DRIFTS, 0.0, seed=1) == (DESIGN, RIG)
    half, lights = worn(DESIGN, RIG, DRIFTS, 0.5, seed=1)
    assert half.skin_mm == pytest.approx(DESIGN.skin_mm - 0.1)
    assert half.materials.infill.shear_modulus_mpa == pytest.approx(0.75 * DESIGN.materials.infill.shear_modulus_mpa)
    assert half.materials.body == DESIGN.materials.body
    assert lights.strips[0].radiance[0] == pytest.approx(0.75 * RIG.strips[0].radiance[0])
    assert lights.strips[1] == RIG.strips[1]


def test_pits_of_less_wear_stay_where_they_are():
    few, many = (worn(DESIGN, RIG, DRIFTS[3:], share, seed=1)[0].markers for share in (0.5, 1.0))
    places, more = (each.centres_mm(DESIGN.footprint_mm) for each in (few, many))
    assert len(more) == pytest.approx(0.5 * 24 * 32, rel=0.1)
    assert len(places) == pytest.approx(len(more) / 2, rel=0.05)
    assert {tuple(each) for each in places.round(9)} <= {tuple(each) for each in more.round(9)}


@pytest.mark.parametrize(
    ("drift", "design", "complaint"),
    [
        (Drift(name="odd", added={"glow": 1.0}), "mini-magictac", "drift 'odd': 'glow' is no number of the design"),
        (Drift(name="odd", factors={"materials.body": 1.0}), "mini-magictac", "'materials.body' is no number"),
        (Drift(name="odd", strips=(1.0,)), "mini-magictac", "1 strips are not allowed: the rig has 4"),
        (Drift(name="odd", added={"skin_mm": -0.8}), "mini-magictac", "the worn design: skin_mm"),
        (Drift(name="odd", pits=Pits(per_mm2=1)), "marker-type", "needs a face without markers"),
    ],
)
def test_drift_that_does_not_fit_is_one_line(drift: Drift, design: str, complaint: str):
    with pytest.raises(ConfigError, match=complaint):
        worn(load_design(design), RIG, (drift,), 1.0, seed=1)


def test_life_is_of_one_unit_on_contacts_of_its_own():
    study = load_study("wear", ["parts=2"], quick=True)
    data = {
        stage.name: stage.recipe for stage in study.stages() if hasattr(stage, "recipe") and stage.name != "learning"
    }
    new, worn_out, other = data["frames"], data["life-02"], data["other-unit"]
    assert worn_out.design.unevenness == new.design.unevenness != other.design.unevenness
    assert worn_out.design.wall_mm == new.design.wall_mm != other.design.wall_mm
    body = new.design.materials.body.sigma_s_per_mm
    assert worn_out.design.materials.body.sigma_s_per_mm == pytest.approx(body + 0.03)
    assert data["life-01"].design.materials.body.sigma_s_per_mm == pytest.approx(body + 0.015)
    alone = data["drift-softer-infill"].design.materials
    assert alone.body == new.design.materials.body
    assert alone.infill.shear_modulus_mpa == pytest.approx(0.5 * new.design.materials.infill.shear_modulus_mpa)
    first, later = (draw_episodes(recipe)[0] for recipe in (new, worn_out))
    assert first.scene.keyframes != later.scene.keyframes
    assert {key.gap_mm for key in first.scene.keyframes} & {-1.2, -1.6}
    assert new.design.skin_mm == pytest.approx(0.3, abs=0.1)
    assert (worn_out.rig.room, worn_out.rig.ambient) == (new.rig.room, new.rig.ambient)  # a unit stays where it is
    assert other.rig.ambient != new.rig.ambient


def test_no_contact_that_is_learned_from_comes_again_on_a_worn_or_a_second_unit():
    study = load_study("wear", ["parts=2"], quick=True)
    places = {}
    for stage in study.stages():
        if hasattr(stage, "simulator"):
            drawn = [each.values for each in draw_episodes(stage.recipe)]
            places[stage.name] = {(each["path.x_mm"], each["path.y_mm"]) for each in drawn}
    learned = places.pop("frames")
    assert "other-unit" in places
    for name, further in places.items():
        assert not learned & further, name
    assert not places["other-unit"] & places["life-01"]


@pytest.mark.usefixtures("learns_in_process")
def test_small_form_tests_life_drifts_and_a_second_unit(tmp_path: Path):
    small = (
        "recipe.episodes=8", "part_episodes=2", "drift_episodes=2", "other_episodes=8", "fine_tuning.epochs=2",
        "learning.epochs=3", "learning.curve=[]", "check_episodes=0",
    )  # fmt: skip
    study = made("wear", *small)
    run(study, tmp_path)
    life = [row for row in rows(tmp_path, "life") if row["label"] == "f_z"]
    assert [(row["wear"], row["read"].split()[0]) for row in life] == [
        (0.0, "beside"), (1.0, "beside"), (0.0, "alone"), (1.0, "alone")
    ]  # fmt: skip
    assert all(np.isfinite([row["error"], row["constant"], row["neighbour"]]).all() for row in life)
    drifts = {row["drift"] for row in rows(tmp_path, "drifts")}
    assert drifts == {"nothing, new", "haze", "softer-infill"}
    cross = [row for row in rows(tmp_path, "cross") if row["label"] == "f_z"]
    assert [row["share"] for row in cross] == [0.0, 0.5, 1.0]
    assert len({row["frames"] for row in cross}) == 1  # the kept half, in all of them
    assert cross[1]["tuned_frames"] < cross[2]["tuned_frames"]


def test_drifts_of_one_name_are_refused():
    with pytest.raises(ConfigError, match="names must all differ"):
        load_study("wear", ["drifts=[{name='a',added={skin_mm=0.1}},{name='a',added={skin_mm=0.2}}]"], quick=True)
