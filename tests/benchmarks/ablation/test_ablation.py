from pathlib import Path

import numpy as np
import pytest
from evaluation.synthetic import PROFILE
from laboratory.ablation.films import ABLATIONS, ablation_key, film_ablated
from laboratory.ablation.scores import (
    MEASURED,
    ablated_footage,
    compare_scores,
    score_ablation,
    without_fusion,
)

from magicsim.errors import RenderError
from magicsim.evaluation.suite import SuiteConfig
from magicsim.evaluation.take import list_cases, read_take, take_key
from magicsim.scenes.scene import SceneConfig, load_scene

SMALL = (
    "design.footprint_mm=[10,12]", "design.cell_mm=2.3", "rig.camera.columns=24", "rig.camera.rows=32",
    "rig.camera.field_mm=8", "render.samples=2", "render.particles=2000", "render.anchor_samples=2",
    "render.anchor_particles=4000", "references=2", "object.radius_mm=3",
    "keyframes=[{frame=0,gap_mm=2.0},{frame=1,gap_mm=-0.4}]",
)  # fmt: skip


@pytest.fixture(scope="module")
def scene() -> SceneConfig:
    return load_scene("pressed", SMALL)


@pytest.mark.slow
def test_every_ablation_keeps_the_truth_and_changes_the_light(scene: SceneConfig, tmp_path: Path):
    takes = film_ablated(scene, list(ABLATIONS), tmp_path)
    full = takes["nothing"]
    assert full.force_n[-1] > 0
    assert (
        isinstance(takes["scattering"], str) or takes["scattering"].radiance[0].mean() < 0.1 * full.radiance[0].mean()
    )
    for name in ("deformation", "grid_refraction", "refraction", "colour", "transparency"):
        take = takes[name]
        assert (take.force_n == full.force_n).all()
        assert (take.gap_mm == full.gap_mm)[take.gap_mm == take.gap_mm].all()
        assert np.abs(take.radiance[-1] - full.radiance[-1]).max() > 1e-3
    assert takes["transparency"].radiance[0].std((0, 1)) == pytest.approx(0, abs=1e-6)
    assert (takes["transparency"].radiance[1] == takes["transparency"].radiance[0]).all(), (
        "an opaque one sees nothing near"
    )
    assert takes["deformation"].radiance[1] == pytest.approx(full.radiance[1], abs=1e-6), "nothing deforms from afar"
    white = takes["colour"].radiance[0].mean((0, 1))
    assert white == pytest.approx(white.mean(), rel=1e-3)


@pytest.mark.slow
def test_filmed_takes_are_read_back(scene: SceneConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    first = film_ablated(scene, ["transparency"], tmp_path)["transparency"]
    monkeypatch.setattr("laboratory.ablation.films.Sensor", lambda *_: pytest.fail("filmed again"))
    assert (film_ablated(scene, ["transparency"], tmp_path)["transparency"].radiance == first.radiance).all()


def test_keys_differ_and_unknown_ablations_are_refused(scene: SceneConfig, tmp_path: Path):
    assert len({take_key(scene), *(ablation_key(scene, name) for name in ABLATIONS)}) == len(ABLATIONS) + 1
    with pytest.raises(RenderError, match=r"unknown ablation 'color' \(did you mean 'colour'\?\)"):
        film_ablated(scene, ["color"], tmp_path)


def test_scores_of_takes_fall_where_the_fusion_is_gone(tiny: tuple[SuiteConfig, Path]):
    suite, cache = tiny
    footage = [
        ablated_footage(case, read_take(cache / f"{take_key(case.scene)}.npz"), suite) for case in list_cases(suite)
    ]
    scores = {
        name: score_ablation(footage, one, suite) for name, one in (("a", PROFILE), ("b", without_fusion(PROFILE)))
    }
    assert set(scores["a"]["measures"]) == set(MEASURED)
    assert scores["b"]["features"]["Clear"]["entropy"] > scores["a"]["features"]["Clear"]["entropy"]
    falls = compare_scores(scores, "a")["b"]
    assert falls["approach_auc"] >= 0
    accuracy = scores["a"]["measures"]["contact_balanced_accuracy"]
    assert accuracy["low"] <= accuracy["value"] <= accuracy["high"]


def test_frames_without_a_grid_are_a_refusal(tiny: tuple[SuiteConfig, Path]):
    suite, cache = tiny
    case = list_cases(suite)[0]
    take = read_take(cache / f"{take_key(case.scene)}.npz")
    dark = type(take)(
        **{name: getattr(take, name) for name in type(take).__slots__} | {"radiance": 0 * take.radiance + 1}
    )
    profile = without_fusion(PROFILE)
    bright = score_ablation([ablated_footage(case, dark, suite)], type(profile)(polarity="dark", tau_b=10), suite)
    assert "show no grid" in bright["refused"]
