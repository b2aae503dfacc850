import pytest

from magicsim.config.presets import preset_names
from magicsim_experiments.study.running import estimate_study
from magicsim_experiments.study.study_file import load_study

CORES, FULL_S, QUICK_S = 2, 3 * 3600, 300


@pytest.mark.parametrize("name", preset_names("study"))
def test_full_form_is_planned_within_three_hours_and_small_form_within_minutes_of_two_cores(name: str):
    for quick, most in ((False, FULL_S), (True, QUICK_S)):
        stages = estimate_study(load_study(name, quick=quick), processes=CORES)
        assert 0 < sum(each.core_seconds for each in stages) / CORES <= most


@pytest.mark.parametrize("name", ["sensitivity", "sensitivity-resolution"])
def test_rows_of_noise_reach_the_frames(name: str):
    """A recipe that draws the camera's noise would leave these rows without a difference."""
    study = load_study(name)
    found = {stage.name: stage.stage.recipe for stage in study.stages() if hasattr(stage.stage, "recipe")}
    wells = {each: recipe.rig.camera.full_well_e for each, recipe in found.items()}
    assert len(set(wells.values())) == 3
    assert all(recipe.camera.full_well_e is None for recipe in found.values())
