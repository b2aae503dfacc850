import numpy as np
import pytest
from pydantic import TypeAdapter

from magicsim import Sensor, load_scene
from magicsim.config.presets import preset_names
from magicsim.geometry.objects.kinds import ObjectConfig
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


@pytest.mark.parametrize("texture", ["dots", "lines"])
def test_all_sizes_of_a_texture_are_pressed_on_cells_of_one_size(texture: str):
    """Finer cells below the larger dots alone, which a design's usual lattice has, would tell them."""
    [recipe] = (stage.recipe for stage in load_study("resolution").stages() if stage.name == f"{texture}-frames")
    keys = {"kind", "radius_mm", "width_mm", "spacing_mm", "size_mm"}
    finest = []
    for entry in recipe.objects[::5]:
        plate = TypeAdapter(ObjectConfig).validate_python(entry.model_dump(include=keys, exclude_none=True))
        scene = load_scene("pressed").model_copy(update={"design": recipe.design, "object": plate})
        nodes = Sensor.for_scene(scene).lattice.nodes_mm
        finest.append([np.diff(np.unique(nodes[:, axis].round(6))).min() for axis in range(2)])
    np.testing.assert_allclose(finest, np.broadcast_to(finest[0], (7, 2)), rtol=1e-6)
