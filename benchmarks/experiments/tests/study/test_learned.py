"""Studies that learn, on made frames in seconds; PyTorch is optional."""

import json
import shutil
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pytest

from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.errors import ConfigError, OutputError
from magicsim_experiments.learn.samples import Label
from magicsim_experiments.study.learned.alignment import axis_angle_deg
from magicsim_experiments.study.learned.answers import Answers
from magicsim_experiments.study.learned.data import data_stages
from magicsim_experiments.study.learned.learned_study import SAID, absolute_error, pairs_figures, pairs_table
from magicsim_experiments.study.learned.localisation import mask_features
from magicsim_experiments.study.learned.ranging import bin_names, gap_bin
from magicsim_experiments.study.study_file import load_study

from .made_study import TINY, contents, made, rows, run

pytestmark = pytest.mark.usefixtures("learns_in_process")


def test_localisation_beats_a_constant(tmp_path: Path):
    run(made("localisation", "recipe.episodes=24", "recipe.episodes_per_sensor=12", "learning.epochs=20"), tmp_path)
    errors = {(row["label"], row["answer"]): row for row in rows(tmp_path, "errors")}
    assert errors["p_x", "small"]["error"] < 0.7 * errors["p_x", "constant answer"]["error"]
    assert errors["f_z", "small"]["error"] < errors["f_z", "constant answer"]["error"]
    assert errors["p_y", "linear fit of geometric features"]["error"] < 0.5  # the true contact's centroid
    assert {row["frames_of"] for row in rows(tmp_path, "units")} == {"presses on known units", "unknown units"}
    promised = {row["label"]: row for row in rows(tmp_path, "beyond") if row["train_frames"] > 0}
    learned = max(row["train_frames"] for row in rows(tmp_path, "curve"))
    assert promised["p_x"]["train_frames"] == pytest.approx(10 * learned)
    assert promised["p_x"]["low"] <= promised["p_x"]["error"] <= promised["p_x"]["high"]
    assert "Extrapolated, not measured" in (tmp_path / "report.html").read_text()
    checks = {row["frames_of"] for row in rows(tmp_path, "checks")}
    assert checks == {"as they are", "without-noise", "finer-rendering"}


def test_training_that_is_killed_resumes_to_the_same_bytes(tmp_path: Path):
    changes = ("recipe.episodes=8", "recipe.episodes_per_sensor=8", "learning.epochs=4", "check_episodes=0")
    run(made("localisation", *changes), tmp_path / "whole")
    study = made("localisation", *changes)
    object.__setattr__(study.learning, "stretch_s", 0.0)  # a checkpoint after every pass
    told = 0

    def killed(_done: float, _total: float, note: str) -> None:
        nonlocal told
        told += "models" in note
        if told == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(study, tmp_path / "killed", progress=killed)
    assert list((tmp_path / "killed/.work").glob("*.checkpoint"))
    run(study, tmp_path / "killed", resume=True)
    assert contents(tmp_path / "killed") == contents(tmp_path / "whole")


def test_ranging_tells_presence_place_and_gap(tmp_path: Path):
    run(made("ranging", "recipe.episodes=24", "recipe.episodes_per_sensor=24"), tmp_path / "out")
    found = {(row["gap"], row["answer"]): row["share"] for row in rows(tmp_path / "out", "detection")}
    assert found["0 to 1 mm", "model"] > 0.9
    results = json.loads((tmp_path / "out/results.json").read_text())
    assert results["headline"]["gap_mm"] < 7
    assert len(results["tables"]["presence"]) == 2 * len(bin_names())


def test_resolution_names_sizes(tmp_path: Path):
    run(made("resolution", "recipe.episodes=16", "recipe.episodes_per_sensor=16", "check_episodes=0"), tmp_path / "out")
    shares = rows(tmp_path / "out", "shares")
    model = [row["share"] for row in shares if row["answer"] == "model" and row["texture"] == "lines"]
    assert model == sorted(model)  # a wider tolerance never makes an answer wrong
    matrix = rows(tmp_path / "out", "confusion-dots")
    assert sum(row["count"] for row in matrix) == 8  # half of the presses
    assert all(row["right"] == (row["truth"] == row["answer"]) for row in matrix)


def test_alignment_fine_tunes_on_other_units(tmp_path: Path):
    changes = (
        "recipe.episodes=12",
        "recipe.episodes_per_sensor=12",
        "fine_tuning.epochs=3",
    )
    run(made("alignment", *changes), tmp_path / "out")
    parts = {row["frames_of"]: row for row in rows(tmp_path / "out", "units") if row["label"] == "r_z"}
    assert parts["other units"]["frames"] == parts["other units, fine-tuned"]["frames"]
    assert parts["other units"]["error"] != parts["other units, fine-tuned"]["error"]
    assert 0 < parts["unknown cylinders"]["frames"] < parts["the unit that it was trained on"]["frames"] * 2


def test_folder_of_another_recipe_and_few_episodes_are_refused(tmp_path: Path):
    study = made("localisation", "recipe.episodes=8")
    run(study, tmp_path / "out")
    with pytest.raises(OutputError, match="holds another study"):
        run(made("localisation", "recipe.episodes=8", "recipe.references=2"), tmp_path / "out", resume=True)
    with pytest.raises(ConfigError, match=r"recipe.episodes = 3 is not allowed with learning.folds = 2"):
        made("localisation", "recipe.episodes=3")
    with pytest.raises(ConfigError, match=r"design.coat is opaque"):
        load_study("ranging", design="gelsight-type-markers")
    with pytest.raises(ConfigError, match=r"recipe.* depth"):
        made("localisation", "recipe.paths=[{kind='touch',depth=1.0}]")


def test_data_of_another_recipe_in_the_place_of_the_studys_own_are_refused(tmp_path: Path):
    study, other = (made("localisation", "recipe.episodes=8", f"recipe.references={count}") for count in (1, 2))
    run(study, tmp_path / "out")
    run(other, tmp_path / "other")
    shutil.rmtree(tmp_path / "out/data/frames")
    shutil.copytree(tmp_path / "other/data/frames", tmp_path / "out/data/frames")
    with pytest.raises(
        OutputError, match=r"data/frames' holds a dataset of another recipe, which differs in references"
    ) as said:
        run(study, tmp_path / "out", resume=True)
    assert "\n" not in str(said.value)


def test_places_and_depths_fit_every_design():
    for design in ("mini-magictac", "gelsight-type-markers", "marker-type"):
        config = load_study("localisation", design=design, quick=True).config
        [path] = config.dataset_recipe().paths
        width, length = config.design.footprint_mm
        assert path.x_mm.high == pytest.approx(0.55 * width / 2)
        assert path.y_mm.high == pytest.approx(0.55 * length / 2)
        assert path.depth_mm.high == pytest.approx(min(2.0, 0.4 * config.design.height_mm))


def test_colour_of_a_cylinder_does_not_tell_the_side_that_it_leans_to():
    for stage in load_study("alignment", quick=True).stages():
        if hasattr(stage, "simulator") and stage.name != "pen":
            drawn = draw_episodes(stage.recipe)
            seen = {(each.scene.object.color[0] > 0.5, each.values["object.yaw_deg"] > 0) for each in drawn}
            assert len(seen) > 2, stage.name  # of Sobol points it would be two: each colour has a side


def test_checks_are_of_the_same_presses():
    plain, quiet, fine = (stage.recipe for stage in load_study("localisation", quick=True).stages()[:3])
    for number in range(3):
        whole, *others = (draw_episodes(recipe)[number] for recipe in (plain, quiet, fine))
        for other in others:
            assert other.scene.keyframes == whole.scene.keyframes
            assert other.scene.design == whole.scene.design
        assert others[0].scene.rig.camera.read_noise_e == 0
        assert others[1].scene.render.samples == 4 * whole.scene.render.samples


def test_geometry_of_masks_angles_and_bins():
    mask = np.zeros((10, 20), bool)
    mask[4:6, 10:12] = True
    np.testing.assert_allclose(mask_features(mask), [0.45, 0.525, 0.02, np.sqrt(0.02)])
    assert not mask_features(np.zeros((4, 4), bool)).any()
    turn = np.radians(30.0)
    matrix = np.array([[np.cos(turn), -np.sin(turn), 0, np.sin(turn), np.cos(turn), 0, 0, 0, 1]])
    np.testing.assert_allclose(axis_angle_deg(matrix), 30.0)
    np.testing.assert_allclose(axis_angle_deg(-matrix), 30.0)  # an axis has no sense
    assert gap_bin(np.array([0.0, 0.5, 1.0, 24.0, 25.0])).tolist() == [1, 1, 2, 5, 5]


def test_changes_of_the_recipe_that_are_no_table_are_one_line():
    with pytest.raises(ConfigError, match="recipe_changes = 5 is not allowed: must be a table"):
        load_study("localisation", ["recipe_changes=5"])


def test_fast_frames_are_read_beside_true_ones_of_the_same_presses():
    frames, _, again = data_stages(made("localisation", "recipe.render.tier=fast").config)
    assert (frames.recipe.render.tier, again.recipe.render.tier) == ("fast", "true")
    assert again.name == "true-rendering"
    assert again.recipe.render.model_dump() | {"tier": "fast"} == frames.recipe.render.model_dump()


def test_pairs_of_presses_show_a_difference_that_lies_within_both_intervals():
    random = np.random.default_rng(0)
    press = np.repeat(np.arange(40), 4)
    own = np.repeat(random.lognormal(0, 1, 40), 4)  # presses differ by far more than designs

    def answers(errors: npt.NDArray[np.float64], numbers: npt.NDArray[np.int64] = press) -> Answers:
        zero = np.zeros(len(errors))
        return Answers(
            table=pa.table(
                {
                    "press": numbers,
                    "truth.p_x": zero,
                    "model.p_x": errors,
                    "linear.p_x": -errors,
                    "constant.p_x": 1 + 0 * errors,
                }
            )
        )

    order = random.permutation(len(press))
    worse, other = own * np.repeat(random.normal(1.2, 0.1, 40), 4), np.repeat(random.lognormal(0, 1, 40), 4)
    parts = {
        "first": answers(own), "worse": answers(worse[order], press[order]), "other": answers(other),
        "half": answers(worse[:80], press[:80]),
    }  # fmt: skip
    found = pairs_table(parts, seed=1)
    by = {(row["on"], row["answer"]): row for row in found.rows}
    assert len(by) == 9
    assert by["worse", SAID["constant"]]["error"] == 0
    row = by["worse", "model"]
    assert row["error"] == pytest.approx(worse.mean() / own.mean() - 1)
    assert 0.1 < row["low"] < row["error"] < row["high"] < 0.3
    assert by["worse", SAID["linear"]]["error"] == pytest.approx(row["error"])
    assert (by["half", "model"]["presses"], by["half", "model"]["frames"]) == (20, 20)
    # What has nothing in common with the first may differ by half of its error and show no difference.
    assert by["other", "model"]["low"] < 0 < by["other", "model"]["high"]
    drawn = pairs_figures(found)
    assert [figure.title.rpartition(": ")[2] for figure in drawn] == ["model", SAID["linear"], SAID["constant"]]
    assert "worse, p_x" in drawn[0].svg


@pytest.mark.parametrize("name", ["localisation", "ranging"])
def test_designs_are_compared_press_by_press(tmp_path: Path, name: str):
    file = tmp_path / "two.toml"
    file.write_text(f"""schema_version = 1
kind = "compare"
study = "{name}"
others = [{{ name = "same", changes = ["rig.camera.columns=24", "rig.camera.rows=32"] }}]
[quick.study_changes]
check_episodes = 0
recipe_changes = {{ episodes = 12, episodes_per_sensor = 12 }}
""")
    study = made(file, "study.learning.epochs=2", "study.learning.curve=[]", "study.learning.folds=2", tiny=TINY[:2])
    run(study, tmp_path / "out")
    found = rows(tmp_path / "out", "pairs")
    assert {row["on"] for row in found} == {"same"}
    # Frames are made alike for both, so nothing differs; an error of 0 has no shares.
    errors = np.array([row["error"] for row in found])
    assert (errors == 0).any()
    assert not errors[np.isfinite(errors)].any()
    assert "pairs-0" in (tmp_path / "out" / "report.html").read_text()


def test_interval_of_units_that_nobody_saw_holds_what_the_next_unit_may_be():
    random, covered = np.random.default_rng(4), {"press": 0, "unit": 0}
    for _ in range(200):
        units = np.repeat(np.arange(12), 20)
        error = np.repeat(np.abs(1 + 0.3 * random.normal(size=12)), 20) + 0.1 * random.random(240)
        columns = {"press": np.arange(240), "unit": units, "truth.P": np.zeros(240), "model.P": error}
        found = Answers(table=pa.table(columns))
        for drawn in covered:
            score = absolute_error(found, "model", Label(name="P"), seed=1, drawn=drawn)
            covered[drawn] += score.low < 1.05 < score.high
            assert score.presses == 240
    assert covered["press"] < 120  # of 200: an interval over presses alone is of these units
    assert covered["unit"] > 170
    few = found.where(found.column("unit") < 2)
    assert absolute_error(few, "model", Label(name="P"), seed=1, drawn="unit") == absolute_error(
        few, "model", Label(name="P"), seed=1
    )
