"""What may scatter, shine and mirror, each against Mitsuba's volumetric path tracer, an independent code."""

import numpy as np
import pytest

from magicsim.errors import RenderError
from magicsim.scenes.timeline import timeline
from magicsim.simulation.sensor import Sensor

TINY = (
    "design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "rig.camera.columns=24", "rig.camera.rows=28",
    "object.radius_mm=3",
)  # fmt: skip
NO_LENS = "rig.lens.thickness_mm=0"
FORWARD = ("design.materials.infill.sigma_s_per_mm=1.5", "design.materials.infill.anisotropy=0.8")
AIR = "rig.strips=[{side='-x',radiance=[1,0.5,0.2],coupling='air'},{side='+y',radiance=[0.1,0.5,1],coupling='air'}]"
CASES = {
    "glossy object": ("object.specular=0.7", "object.roughness=0.25"),
    "scattering body": (
        NO_LENS, "design.materials.body.sigma_s_per_mm=0.3", "design.materials.infill.sigma_s_per_mm=0",
    ),
    "both scatter": (
        NO_LENS, "design.materials.body.sigma_s_per_mm=0.6", "design.materials.infill.sigma_s_per_mm=1.0",
    ),
    "scattering block without a grid": (NO_LENS, "design.materials.body.sigma_s_per_mm=0.3", "design.cell_mm=0"),
    "forward scattering": FORWARD,
    "strips behind air": (AIR,),
    "light of the room": ("rig.strips=[]", "rig.ambient=[0.5,1,0.7]"),
    "a room with a window": ("rig.ambient=[0.5,0.6,0.7]", "rig.room='window'"),
    "rough interfaces": ("design.roughness.skin=0.2", "design.roughness.walls=0.2"),
    "missing walls": ("design.unevenness.torn_share=0.1",),
    "bubbles and flakes": (
        "design.inclusions.bubbles_per_mm3=2", "design.inclusions.bubble_radius_mm=[0.05,0.2]",
        "design.inclusions.flakes_per_mm3=2", "design.inclusions.flake_radius_mm=[0.05,0.2]",
    ),
    "absorbing body": ("design.materials.body.absorption_per_mm=0.1",),
}  # fmt: skip
QUICK = "both scatter"


def means(scene, turns):
    """Mean radiance of each channel and its standard error over independent images."""
    sensor = Sensor.for_scene(scene)
    view = sensor.view(timeline(scene)[0], sensor.rest)
    found = [sensor.renderer.plain_radiance(view, turn=turn).mean((0, 1), dtype=np.float64) for turn in range(turns)]
    return np.mean(found, 0), np.std(found, 0, ddof=1) / np.sqrt(turns)


def compare(small_scene, overrides, *, particles, samples, images=4):
    """Relative difference of the channels' means from those by path tracing, and its standard error."""
    ours, error = means(
        small_scene("near", *TINY, *overrides, "render.samples=32", f"render.particles={particles}"), turns=images
    )
    theirs, path_error = means(
        small_scene("near", *TINY, *overrides, "render.estimator=path", f"render.samples={samples}"), turns=6
    )
    return ours / theirs - 1, np.hypot(error / ours, path_error / theirs)


@pytest.mark.parametrize("case", [pytest.param(c, marks=() if c == QUICK else pytest.mark.slow) for c in CASES])
def test_mean_radiance_is_that_of_path_tracing(case, small_scene):
    difference, noise = compare(small_scene, CASES[case], particles=80_000, samples=112)
    assert noise.max() < 0.015, "too noisy to tell anything"
    assert (np.abs(difference) < 0.01 + 2 * noise).all(), f"differ by {difference}, standard error {noise}"


@pytest.mark.slow
def test_a_rough_skin_is_that_of_the_renderers_own_rough_material(small_scene, monkeypatch):
    # Its single bounces lose little at the few meetings with the skin; on walls they lose a part of everything.
    skin = ("design.roughness.skin=0.1",)

    def single_bounces(inside, outside, alpha, top_mm):
        del top_mm
        kind = {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha} if alpha else {"type": "dielectric"}
        return {**kind, "int_ior": inside, "ext_ior": outside}

    monkeypatch.setattr("magicsim.light.world.scene_dict.interface_bsdf", single_bounces)
    difference, noise = compare(small_scene, skin, particles=300_000, samples=512)
    assert noise.max() < 0.01
    assert (np.abs(difference) < 0.01 + 2 * noise).all(), f"differ by {difference}, standard error {noise}"


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_mean_radiance_is_that_of_path_tracing_within_one_percent(case, small_scene):
    difference, noise = compare(small_scene, CASES[case], particles=1_000_000, samples=1024, images=12)
    assert noise.max() < 0.005
    assert (np.abs(difference) < 0.01).all(), f"differ by {difference}, standard error {noise}"


def test_reduced_scattering_alone_is_darker_than_forward_scattering(small_scene):
    # Reduction keeps what diffuses, but loses the light that one or two forward collisions send out of the trap.
    bright, _ = means(small_scene("near", *TINY, *FORWARD), turns=2)
    dark, _ = means(small_scene("near", *TINY, *FORWARD, "render.forward_collisions=0"), turns=2)
    assert (dark < 0.9 * bright).all()


def test_path_refuses_a_scattering_body_under_a_lens(small_scene):
    scene = small_scene("near", "render.estimator=path", "design.materials.body.sigma_s_per_mm=0.3")
    with pytest.raises(RenderError, match=r"lens\.thickness_mm = 2 is not allowed"):
        Sensor.for_scene(scene)


def test_clear_lens_over_a_scattering_body_scatters_nothing(small_scene):
    # The same haze behind a thick lens: were the plate to scatter as well, the image would be far brighter.
    haze = ("design.materials.body.sigma_s_per_mm=0.3", "design.materials.body.absorption_per_mm=0", *TINY)
    bare, _ = means(small_scene("rest", *haze[:-1], NO_LENS), turns=2)
    thick, _ = means(small_scene("rest", *haze[:-1], "rig.lens.thickness_mm=6"), turns=2)
    assert (thick < 1.15 * bare).all()
