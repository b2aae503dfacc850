"""Labels against what is seen: clean frames, without noise, in which the printed grid is tracked as in a real video."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from magicsim.camera.projection import project_px
from magicsim.deform.lattice.structure import build_lattice
from magicsim.geometry.grid import resolve_grid
from magicsim.light.variant import SCALAR_VARIANT, activate_variant
from magicsim.scenes.scene import load_scene
from magicsim.simulation.episode import Episode
from magicsim.simulation.stream import simulate

Array = npt.NDArray[np.float64]
CLEAN = ["rig.camera.full_well_e=1e12", "rig.camera.read_noise_e=0", "rig.camera.fixed_pattern=0"]
ONE_LAYER = [
    "design.skin_mm=1.5", "design.core_mm=1.0", "design.materials.infill.ior=1.49", "rig.lens.thickness_mm=1",
    "render.anchor_samples=0",
]  # fmt: skip
"""A single layer of cells of the walls' own index: what one sees of a crossing of walls is its middle."""
CLEAR_BLOCK = [
    "design.footprint_mm=[14,14]", "design.cell_mm=0", "design.core_mm=2.4", "design.lattice.spacing_mm=0.5",
    "design.lattice.cells_across=0", "design.materials.body.sigma_s_per_mm=0.05", "rig.lens.thickness_mm=1",
    "rig.camera.columns=80", "rig.camera.rows=80", "rig.camera.field_mm=8", "rig.camera.exposure_grey=12",
    "render.samples=32", "render.particles=60000", "render.anchor_samples=0", "object.color=[0.9,0.9,0.9]",
    "contact.friction=0",
]  # fmt: skip
"""No grid in the way: a pale ball is dimmer where it touches than beside it, where light leaves the bent skin."""
COATED = [
    "design=gelsight-type", "design.footprint_mm=[14,14]", "design.lattice.spacing_mm=0.5", "rig=three-sides-rgb",
    "rig.camera.columns=80", "rig.camera.rows=80", "rig.camera.field_mm=8", "render.samples=64",
    "render.particles=60000", "render.anchor_samples=0", "object={kind='punch',radius_mm=1.5}", "contact.friction=0",
]  # fmt: skip
"""A flat punch seen from behind a coat: its image changes around the rim, where the coat leans, and not below it."""
DOT_PITCH_MM, DOT_MM = 1.6, 0.7
MARKED = [
    *COATED[:-2], "contact.friction=1", "design.lattice.spacing_mm=1", "design.footprint_mm=[11,11]",
    "design.coat.specular=0", "render.samples=48", "render.particles=20000",
    f"design.markers={{kind='dots',pitch_mm={DOT_PITCH_MM},diameter_mm={DOT_MM},color=[0.02,0.02,0.02]}}",
]  # fmt: skip
"""Black dots on a grey coat, or between coat and camera; without gloss, so that what is dark is a dot."""
PRESS = """
schema_version = 1
design = "mini-magictac"
rig = "digit-rgb"
references = 1
[object]
kind = "sphere"
radius_mm = 4.0
color = [0.02, 0.02, 0.02]
[contact]
friction = 1.0
"""
STORIES = {
    "small": [(0, "gap_mm = -0.25"), (1, "gap_mm = -0.5")],
    "aside": [(0, "gap_mm = -0.3\nx_mm = 0.4\ny_mm = -0.6"), (1, "gap_mm = -0.8\nx_mm = 0.4\ny_mm = -0.6")],
    "sheared": [(0, "gap_mm = -0.3"), (1, "gap_mm = -0.5\nx_mm = 0.5\ny_mm = 0.3")],
    "full": [
        (0, "gap_mm = -0.2"),
        (3, "gap_mm = -0.5"),
        (9, "gap_mm = -0.5\nx_mm = 0.5\ny_mm = 0.3"),
        (12, "gap_mm = -0.5\nx_mm = 0.5\ny_mm = 0.3\ntwist_deg = 10.0"),
    ],
}
SIZES = {
    "small": [
        "design.footprint_mm=[8,8]", "rig.camera.columns=48", "rig.camera.rows=48", "rig.camera.field_mm=5",
        "render.samples=24", "render.particles=40000",
    ],
    "full": [
        "design.footprint_mm=[14,14]", "rig.camera.columns=120", "rig.camera.rows=120", "rig.camera.field_mm=10",
        "render.samples=64", "render.particles=200000",
    ],
}  # fmt: skip
RETURN_PX = 0.2
"""A track that does not come back to its start when followed backwards is lost (forward-backward error) [px]."""


@dataclass(frozen=True)
class Tracks:
    """Displacements of the visible crossings of walls, by scored frame, shape (frames, crossings, 2) [px]."""

    labelled: Array
    seen: Array
    is_kept: npt.NDArray[np.bool_]
    """Which crossings the tracker still holds, shape (frames, crossings)."""


def episode(story: str, folder: Path, *settings: str) -> Episode:
    if activate_variant() == SCALAR_VARIANT:
        pytest.skip("the fluence estimator needs LLVM or CUDA")
    path = folder / "press.toml"
    path.write_text(PRESS + "".join(f"[[keyframes]]\nframe = {frame}\n{state}\n" for frame, state in STORIES[story]))
    return simulate(load_scene(path, [*CLEAN, *settings]))


def outlined(image: Array, centre_px: Array) -> npt.NDArray[np.bool_]:
    """What a bright contact fills: from its middle outwards down to the steepest fall to the object around it."""
    angles, reach = 72, 32
    grey = cv2.GaussianBlur(image.astype(np.float32).mean(2), (0, 0), 0.8)
    polar = cv2.warpPolar(grey, (reach, angles), tuple(centre_px), reach, cv2.WARP_POLAR_LINEAR)
    radius = np.median([np.roll(np.diff(polar[:, 4:]).argmin(1), turn) for turn in range(-2, 3)], 0) + 4.5
    turn = 2 * np.pi * np.arange(angles) / angles
    corners = centre_px + radius[:, None] * np.stack([np.cos(turn), np.sin(turn)], 1)
    filled = cv2.fillPoly(np.zeros(grey.shape, np.uint8), [np.rint(corners).astype(np.int32)], 1)
    return filled > 0


def evened(image: npt.NDArray[np.uint8], pitch_px: float) -> npt.NDArray[np.uint8]:
    """The grid alone: brightness and contrast are the same everywhere, so that light that moves is no motion."""
    grey = image.astype(np.float32).mean(2)
    flat = grey - cv2.GaussianBlur(grey, (0, 0), pitch_px / 2)
    spread = np.sqrt(cv2.GaussianBlur(flat**2, (0, 0), pitch_px / 2)) + 1e-3
    return np.clip(128 + 50 * flat / spread, 0, 255).astype(np.uint8)


def track(found: Episode, *, share: float = 0.5) -> Tracks:
    """Follows the crossings with the flow of Lucas and Kanade, from frame to frame, and projects their labels.

    Args:
        found: Frames with labels.
        share: Height in the layer of what is seen of a crossing, from its lower plane (0) to its upper one (1).
    """
    design, rig = found.scene.design, found.scene.rig
    nodes = build_lattice(design).nodes_mm
    grid = resolve_grid(design)
    below, above = (np.abs(nodes[:, 2] - z) < 1e-6 for z in grid.planes_mm(2))

    def places_px(moved: Array) -> Array:
        return project_px((1 - share) * moved[below] + share * moved[above], design, rig.lens, rig.camera)

    start = places_px(nodes)
    pitch_px = rig.camera.columns / rig.camera.field_mm
    inner = (np.abs(nodes[below][:, :2]) < grid.planes_mm(0)[-1] - 1e-6).all(1)
    inner &= ((start > pitch_px / 2) & (start < rig.camera.columns - 1 - pitch_px / 2)).all(1)
    window = 2 * round(pitch_px * 0.4) + 1
    options = {"winSize": (window, window), "maxLevel": 0, "criteria": (3, 50, 1e-3)}
    before, here = evened(found.references[0].image, pitch_px), np.float32(start[inner])[:, None]
    labelled, seen, kept = [], [], []
    alive = np.ones(inner.sum(), bool)
    for frame in found.scored:
        now = evened(frame.image, pitch_px)
        there = cv2.calcOpticalFlowPyrLK(before, now, here, None, **options)[0]
        back = cv2.calcOpticalFlowPyrLK(now, before, there, None, **options)[0]
        alive &= np.linalg.norm((back - here)[:, 0], axis=1) < RETURN_PX
        before, here = now, there
        labelled.append((places_px(nodes + frame.displacements_mm) - start)[inner])
        seen.append(here[:, 0] - start[inner])
        kept.append(alive.copy())
    return Tracks(labelled=np.array(labelled), seen=np.array(seen), is_kept=np.array(kept))


def assert_tracks_agree(tracks: Tracks, *, least_px: float) -> None:
    missed = np.linalg.norm(tracks.seen - tracks.labelled, axis=2)
    assert np.linalg.norm(tracks.labelled, axis=2).max() > least_px
    assert tracks.is_kept.mean() > 0.9
    assert missed[tracks.is_kept].max() < 0.5
    assert np.median(missed) < 0.1


def test_labelled_displacements_are_those_of_the_grid_in_the_image(tmp_path: Path):
    assert_tracks_agree(track(episode("small", tmp_path, *ONE_LAYER, *SIZES["small"])), least_px=0.8)


@pytest.mark.slow
def test_labelled_displacements_are_those_of_the_grid_under_press_shear_and_twist(tmp_path: Path):
    assert_tracks_agree(track(episode("full", tmp_path, *ONE_LAYER, *SIZES["full"])), least_px=2.5)


@pytest.mark.slow
def test_walls_that_guide_light_are_seen_where_they_begin(tmp_path: Path):
    found = episode("full", tmp_path, *ONE_LAYER, *SIZES["full"], "design.materials.infill.ior=1.46")
    middle, upper = (
        float(np.median(np.linalg.norm(tracks.seen - tracks.labelled, axis=2)[-1]))
        for tracks in (track(found), track(found, share=0.8))
    )
    assert upper < 0.15 < middle


@pytest.mark.slow
@pytest.mark.parametrize("case", ["clear", "coated"])
def test_contact_mask_covers_what_is_seen_of_the_contact(case: str, tmp_path: Path):
    settings, sign, shares = {
        "clear": (CLEAR_BLOCK, lambda change: change, (0.85, 0.9)),
        "coated": (COATED, lambda change: -np.abs(change), (0.85, 0.8)),  # a sharp rim touches at single points
    }[case]
    found = episode("aside", tmp_path, *settings)
    rest, design, rig = found.references[0].image.astype(float), found.scene.design, found.scene.rig
    for frame, least in zip(found.scored, shares, strict=True):
        centre = project_px(np.array([0.4, -0.6, frame.truth.depth_mm]), design, rig.lens, rig.camera)
        seen, mask = outlined(sign(frame.image - rest), centre), frame.contact_mask
        assert (seen & mask).sum() / (seen | mask).sum() > least
        np.testing.assert_allclose(np.argwhere(seen).mean(0), np.argwhere(mask).mean(0), atol=1.0)
    # contact that was labelled a quarter of the field away would not pass
    assert (np.roll(seen, 20, 1) & mask).sum() / (np.roll(seen, 20, 1) | mask).sum() < 0.5


def dots_px(image: npt.NDArray[np.uint8], near_px: Array, reach_px: float) -> Array:
    """Centres of black dots near some places, by their darkness, shape (places, 2)."""
    grey = image.astype(np.float32).mean(2)
    column, row = np.meshgrid(np.arange(grey.shape[1]), np.arange(grey.shape[0]))
    found = []
    for place in near_px:
        inside = np.hypot(column - place[0], row - place[1]) < reach_px
        light, dark = np.percentile(grey[inside], [80, 2])
        weight = np.clip((light + dark) / 2 - grey, 0, None) * inside
        found.append([(weight * each).sum() / weight.sum() for each in (column, row)])
    return np.array(found)


@pytest.mark.parametrize("depth_mm", [0.0, pytest.param(0.6, marks=pytest.mark.slow)])
def test_labelled_markers_are_the_dots_in_the_image(depth_mm: float, tmp_path: Path):
    found = episode("sheared", tmp_path, *MARKED, f"design.markers.depth_mm={depth_mm}")
    camera = found.scene.rig.camera
    scale, rest = camera.columns / camera.field_mm, found.scored[0].labels.markers_px
    reach = DOT_PITCH_MM * scale / 2
    seen = ((rest > 1.5 * reach) & (rest < camera.columns - 1.5 * reach)).all(1)
    assert seen.sum() >= 9
    for frame in found.scored:
        assert frame.labels.markers_mm.shape == (len(rest), 3)
        labelled = frame.labels.markers_px[seen]
        missed = np.linalg.norm(dots_px(frame.image, labelled, reach) - labelled, axis=1)
        assert np.median(missed) < 0.3
        assert missed.max() < 1.0
    moved = np.linalg.norm(found.scored[1].labels.markers_px - rest, axis=1)[seen]
    assert moved.max() > 2.0  # labels that stayed behind would not pass
