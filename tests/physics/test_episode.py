"""Whole episodes: leaving out changes nothing, and the same seed gives the same bytes."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from magicsim.detectors.picture import read_image
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.simulation.episode import Episode
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.stream import simulate

TINY = (
    "design.footprint_mm=[12,16]",
    "rig.camera.field_mm=10",
    "rig.camera.columns=24",
    "rig.camera.rows=32",
    "render.samples=2",
    "render.particles=2000",
    "render.anchor_samples=4",
    "render.anchor_particles=8000",
    "design.lattice.spacing_mm=2.0",
    "design.lattice.cells_across=0",
    "references=2",
)

STORY = """
schema_version = 1
design = "mini-magictac"
rig = "digit-rgb"
seed = 5

[object]
kind = "sphere"
radius_mm = 5.0

[[keyframes]]
frame = 0

[[keyframes]]
frame = 1
gap_mm = 2.0

[[keyframes]]
frame = 2
gap_mm = -0.4

[[keyframes]]
frame = 3
gap_mm = -0.4

[[keyframes]]
frame = 4
gap_mm = 2.0

[[keyframes]]
frame = 5
flashlight = true

[[keyframes]]
frame = 6
"""


@pytest.fixture(scope="module")
def scene_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("story") / "story.toml"
    path.write_text(STORY)
    return path


@pytest.fixture(scope="module")
def story(scene_file: Path) -> SceneConfig:
    """Clear, near, pressed, held, near again, flashlight, clear; small."""
    return load_scene(scene_file, TINY)


@pytest.fixture(scope="module")
def episode(story: SceneConfig) -> Episode:
    return simulate(story)


def test_leaving_out_changes_no_frame_and_no_truth(story, episode):
    lean, full = plan_scene(story), plan_scene(story, leave_out=False)
    assert sum(frame.same_as is None for frame in lean.frames) < sum(frame.same_as is None for frame in full.frames)
    for one, other in zip(episode.frames, simulate(story, plan=full).frames, strict=True):
        np.testing.assert_array_equal(one.image, other.image)
        np.testing.assert_array_equal(one.contact_mask, other.contact_mask)
        assert one.truth.force_n == pytest.approx(other.truth.force_n, abs=1e-9)
        assert one.truth.frame_class == other.truth.frame_class


def test_outputs_not_asked_for_are_not_computed(story, episode):
    bare = story.model_copy(
        update={"output": story.output.model_copy(update={"contact_mask": False, "displacements": False})}
    )
    for one, other in zip(episode.frames, simulate(bare).frames, strict=True):
        assert other.labels.contact_mask is None
        assert other.labels.displacements_mm is None
        np.testing.assert_array_equal(one.image, other.image)


def test_truth_follows_the_story(episode):
    scored = episode.scored
    assert [frame.truth.frame_class for frame in scored] == [
        "Clear", "Near", "Contact", "Contact", "Near", "Light", "Clear",
    ]  # fmt: skip
    held = scored[3].truth
    assert held.depth_mm == pytest.approx(0.4)
    assert held.force_n[2] > 0.05
    assert held.solve.iterations == 0
    assert scored[2].truth.solve.iterations > 0
    assert scored[1].truth.force_n == (0.0, 0.0, 0.0)


def test_frames_are_byte_identical_with_one_thread_and_with_all(scene_file, episode, tmp_path):
    settings = [part for each in (*TINY, "output.report=false", "output.preview=false") for part in ("--set", each)]
    out = tmp_path / "out"
    command = [sys.executable, "-m", "magicsim", "simulate", str(scene_file), "--out", str(out), "--threads", "1"]
    subprocess.run([*command, *settings], check=True, capture_output=True)
    stored = [read_image(path) for path in sorted((out / "frames").glob("*.png"))]
    assert len(stored) == 9
    for image, frame in zip(stored, episode.frames, strict=True):
        np.testing.assert_array_equal(image, frame.image)
