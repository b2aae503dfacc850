"""Every study that learns, on frames that are rendered: what its labels say stands in the pictures.

Made frames would not notice if the renderer left out an object or its texture.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from magicsim.dataset.generate import generate_dataset
from magicsim.workers.attempt import choose_workers
from magicsim_experiments.learn.samples import Samples
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.study.stages import DatasetStage
from magicsim_experiments.study.study_file import load_study

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("learns_in_process")]
TINY = (
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=2", "design.lattice.cells_across=0",
    "rig.camera.columns=24", "rig.camera.rows=32", "rig.camera.field_mm=10", "camera_scale=1.0", "check_episodes=0",
    "learning.folds=2", "learning.folds_used=1", "recipe.rooms=[]", "recipe.camera={full_well_e=1e9,read_noise_e=0.0}",
    "recipe.render.samples=8", "recipe.render.particles=4000", "recipe.render.anchor_samples=8",
    "recipe.render.anchor_particles=8000",
)  # fmt: skip
PRESS = (
    "gap_mm=0.5,depth_mm=1.0,friction=0.5,approach_frames=1,press_frames=1,shear_frames=0,twist_frames=0,"
    "hold_frames=0,release_frames=0"
)
TOUCH = f"recipe.paths=[{{kind='touch',x_mm={{low=-3,high=3}},y_mm={{low=-4,high=4}},{PRESS}}}]"


def studied(name: str, *settings: str, episodes: int):
    counts = (f"recipe.episodes={episodes}", f"recipe.episodes_per_sensor={episodes}")
    return load_study(name, [*TINY, *counts, *settings], quick=True)


def rendered(read, stage: DatasetStage, folder: Path) -> Samples:
    generate_dataset(stage.recipe, folder, options=choose_workers(1))
    return read(folder, LearningSettings(long_side_px=0))


def tied(one: np.ndarray, other: np.ndarray) -> float:
    """Size of the correlation."""
    return abs(np.corrcoef(one, other)[0, 1])


def test_place_of_a_touch_is_where_the_picture_changes(tmp_path: Path):
    study = studied("localisation", TOUCH, episodes=8)
    found = rendered(study.learning.read, study.data[0], tmp_path / "frames")
    assert len(found) == 8
    assert tied(found.features[:, 1], found.targets[:, 0]) > 0.9  # centre of the change in green, along columns
    assert tied(found.features[:, 7], found.targets[:, 1]) > 0.9


def test_near_object_is_in_the_picture_before_it_touches(tmp_path: Path):
    hover = "{kind='hover',gap_mm=1.5,nearest_mm=0.5,approach_frames=1,retreat_frames=0}"
    ball = "recipe.objects=[{kind='sphere',radius_mm=5.0,color=[0.8,0.8,0.8]}]"
    study = studied("ranging", f"recipe.paths=[{hover},{{kind='clear',clear_frames=1}}]", ball, episodes=8)
    found = rendered(study.learning.read, study.data[0], tmp_path / "frames")
    change = np.square(found.inputs("difference")).mean((1, 2, 3))
    is_there = found.targets[:, 0] > 0
    assert 0 < is_there.sum() < len(found)
    assert change[is_there].min() > 3 * change[~is_there].max()


def test_lean_of_a_cylinder_is_in_the_picture(tmp_path: Path):
    study = studied("alignment", TOUCH, "pen_episodes=0", episodes=8)
    found = rendered(study.learning.read, study.data[0], tmp_path / "frames")
    turn = np.radians(2 * found.targets[:, 3])
    assert tied(found.features[:, 16], np.sin(turn)) > 0.8  # sine of twice the lean of the change in green


def test_texture_is_in_the_picture(tmp_path: Path):
    study = studied("resolution", TOUCH, "textures=['lines']", "sizes_mm=[0.5,1.5]", episodes=6)
    stage, learning = study.stages()
    fine, coarse = (
        rendered(
            learning.read,
            replace(stage, recipe=stage.recipe.model_copy(update={"objects": (plate,), "episodes": 3})),
            tmp_path / str(plate.width_mm),
        )
        for plate in stage.recipe.objects
    )
    assert set(fine.targets[:, 0]) == {0.5}
    assert set(coarse.targets[:, 0]) == {1.5}
    np.testing.assert_array_equal(fine.references, coarse.references)
    assert (np.abs(fine.images - coarse.images).max((1, 2, 3)) > 8).all()  # the same presses of other plates


def test_worn_face_is_in_the_picture_and_a_touch_still_shows(tmp_path: Path):
    pits = "drifts=[{name='pits',pits={per_mm2=0.3,diameter_mm=0.8,color=[0.9,0.9,0.9]}}]"
    study = studied("wear", TOUCH, pits, "parts=1", "part_episodes=6", episodes=6)
    [worn] = [stage for stage in study.stages() if stage.name == "life-01"]
    new, old = (rendered(study.learning.read, each, tmp_path / each.name) for each in (study.data[0], worn))
    assert np.abs(old.references[0] - new.references[0]).max() > 15
    for found in (new, old):
        assert tied(found.features[:, 1], found.targets[:, 0]) > 0.8
