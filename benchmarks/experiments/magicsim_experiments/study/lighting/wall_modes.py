"""How much of the radiance that reaches the camera was turned at walls of the grid, by which kind of event."""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array
from magicsim.camera.projection import focal_px, pixel_slopes
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import resolve_grid
from magicsim.scenes.rig import DARK, INSET_MM, LedStrip, Rig
from magicsim_experiments.study.lighting.path_kernel import follow_paths, fresnel

ROOM = "room"
"""What the light below the contact face is called, beside the strips."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WallModes:
    """Radiance at the camera, mean over pixels, of paths of one draw."""

    lights: tuple[str, ...]
    radiance: Array
    """Linear RGB by light, kinds of reflections on the whole way and on the last leg, shape (lights, 4, 4, 3)."""
    events: Array
    """Mean number of each event on a way, weighted by radiance, by light, shape (lights, 5)."""
    lost: float
    """Weight that was given up."""


def refuse_unlike(design: ElastomerDesign, rig: Rig) -> None:
    """Refuses what the boxes of the kernel are not."""
    problems = {
        "design.cell_mm = 0: there are no walls": not design.has_grid,
        "design.face is set: the face must be flat": design.face is not None,
        "design.coat is set: the face must be bare": design.coat is not None,
        "design.markers is set: the face must be bare": design.markers is not None,
        f"design.skin_mm = {design.skin_mm:g}: must be above {INSET_MM:g}, where strips lie": design.skin_mm
        <= INSET_MM,
        "rig.leds or rig.ring is set: strips alone are followed": bool(rig.leds) or rig.ring is not None,
        "a strip's coupling is 'air': must be 'contact'": any(strip.coupling != "contact" for strip in rig.strips),
    }
    for problem, is_so in problems.items():
        if is_so:
            raise ConfigError(f"study 'light-modes' cannot be done: {problem}")


def wall_modes(design: ElastomerDesign, rig: Rig, *, paths: int, seed: int) -> WallModes:
    """Follows paths from pixels drawn evenly.

    Args:
        rig: Strips, lens, camera; the room counts with its mean radiance.
    """
    refuse_unlike(design, rig)
    grid, infill, body = resolve_grid(design), design.materials.infill, design.materials.body
    assert grid is not None
    assert infill is not None
    width, length = design.footprint_mm
    top = design.height_mm + rig.lens.thickness_mm
    ways, weights = _starts(design, rig, top_mm=top, count=paths, seed=seed)
    found, events, lost = follow_paths(
        ways, weights, seed, np.array([-width / 2, -length / 2, 0.0]), np.array([width / 2, length / 2, top]),
        grid.origin_mm.astype(float), grid.pitch_mm.astype(float), grid.cell_mm.astype(float),
        np.array(grid.counts, np.int64), np.array([body.ior, infill.ior]),
        np.array([body.sigma_s_per_mm, infill.sigma_s_per_mm]),
        np.array([body.absorption_per_mm, infill.absorption_per_mm]), np.array([body.anisotropy, infill.anisotropy]),
        np.array([_strip_row(strip, design) for strip in rig.strips]).reshape(-1, 7),
    )  # fmt: skip
    is_dark = rig.room == DARK
    shining = np.array([
        *(np.array(strip.radiance) / body.ior**2 for strip in rig.strips), np.array(rig.ambient) * (not is_dark)
    ])  # fmt: skip
    sums = found.sum((1, 2))
    return WallModes(
        lights=(*(strip.side for strip in rig.strips), ROOM),
        radiance=found[..., None] * shining[:, None, None] / paths,
        events=events / np.maximum(sums, 1e-300)[:, None],
        lost=float(lost) / paths,
    )


def _starts(design: ElastomerDesign, rig: Rig, *, top_mm: float, count: int, seed: int) -> tuple[Array, Array]:
    """Places on the lens plate and directions inside of it, shape (paths, 2, 3), and transmitted shares."""
    random = np.random.default_rng([seed, 37])
    camera, focal = rig.camera, focal_px(design, rig.lens, rig.camera)
    slopes = pixel_slopes(camera, focal).reshape(-1, 2)
    chosen = slopes[random.integers(0, len(slopes), count)] + random.uniform(-0.5, 0.5, (count, 2)) / focal
    air = np.column_stack([chosen[:, 0], -chosen[:, 1], -np.ones(count)])
    places = np.column_stack([air[:, :2] * camera.distance_mm, np.full(count, top_mm)])
    air /= np.linalg.norm(air, axis=1, keepdims=True)
    index = design.materials.body.ior
    inside = air / index
    inside[:, 2] = -np.sqrt(1 - (inside[:, :2] ** 2).sum(1))
    passed = np.array([1 - fresnel(cosine, 1.0, index) for cosine in -air[:, 2]])
    half = np.array(design.footprint_mm) / 2
    passed[(np.abs(places[:, :2]) > half).any(1)] = 0.0  # beside the plate
    return np.stack([places, inside], 1), passed


def _strip_row(strip: LedStrip, design: ElastomerDesign) -> list[float]:
    axis, sign = "xy".index(strip.side[1]), 1.0 if strip.side[0] == "+" else -1.0
    half, height = np.array(design.footprint_mm) / 2, design.height_mm
    reach = max(height / 2 - strip.margin_mm, 0.1 * height)
    return [
        float(axis), sign, sign * (half[axis] - INSET_MM), half[1 - axis] - strip.margin_mm, height / 2 - reach,
        height / 2 + reach, strip.reflectance,
    ]  # fmt: skip
