"""How sharply a see-through sensor shows an edge behind it: modulation transfer by distance, for forward scattering.

The room shines from behind, and a black plate covers half of it up to the sensor's middle. The image over that without
the plate, which takes out the grid's own pattern, is an edge-spread function; its derivative's Fourier transform over
that at zero frequency is the modulation transfer.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from laboratory.benchmark import logged, machine
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState, timeline
from magicsim.simulation.sensor import Sensor

Array = npt.NDArray[np.float64]
GAPS_MM = (0.05, 1.0, 5.0, 10.0)
FREQUENCIES_PER_MM = (0.05, 0.1, 0.2, 0.4, 0.8)
COLUMNS, ROWS = 240, 48
SCENE = (
    "rig.strips=[]", "rig.ambient=[1,1,1]", "references=0", "rig.camera.white_balance=false",
    "design.materials.infill.sigma_s_per_mm=1.5", "design.materials.infill.anisotropy=0.8",
    f"rig.camera.columns={COLUMNS}", f"rig.camera.rows={ROWS}", "render.anchor_samples=0",
    "object={kind='box',size_mm=[60,120,2],edge_radius_mm=0.05,color=[0,0,0]}",
)  # fmt: skip
"""Black plate; sigma_s and anisotropy with the reduced coefficient of the default design, 0.3 per mm."""
METHODS = {
    "path": ("render.estimator=path", "render.samples=256"),
    "reduced": ("render.forward_collisions=0", "render.samples=64", "render.particles=400000"),
    "2 forward": ("render.forward_collisions=2", "render.samples=64", "render.particles=400000"),
    "8 forward": ("render.forward_collisions=8", "render.samples=64", "render.particles=400000"),
}
TURNS = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class BlurRow:
    """Modulation transfer by one method at one distance."""

    method: str
    gap_mm: float
    transfer: list[float]
    """At `FREQUENCIES_PER_MM`, of the contact face."""
    error: list[float]
    """Standard error over independent images."""
    contrast: float
    """Step of the edge over the level without a plate."""


def run_blur(*, quick: bool = False) -> dict[str, Any]:
    """All methods at all distances.

    Args:
        quick: Fewer images and samples.
    """
    turns = 3 if quick else TURNS
    rows = logged(
        measure_blur(method, gap, turns=turns, overrides=("render.samples=16",) if quick else ())
        for gap in GAPS_MM
        for method in METHODS
    )
    return {
        "kind": "blur",
        "quick": quick,
        "frequencies_per_mm": list(FREQUENCIES_PER_MM),
        "results": [asdict(row) for row in rows],
        "machine": machine(),
    }


def measure_blur(method: str, gap_mm: float, *, turns: int, overrides: tuple[str, ...] = ()) -> BlurRow:
    """One row.

    Args:
        method: One of `METHODS`.
        gap_mm: Distance of the plate from the contact face [mm].
        turns: Number of independent images.
        overrides: Further settings.
    """
    place = f"keyframes=[{{frame=0,gap_mm={gap_mm},x_mm=-30}}]"
    scene = load_scene("near", [*SCENE, place, *METHODS[method], *overrides], seed=0)
    sensor = Sensor.for_scene(scene)
    covered, bare = (_profiles(sensor, state, turns) for state in (timeline(scene)[0], UNTOUCHED))
    edges = covered / bare.mean(0)
    width = scene.rig.camera.field_mm / COLUMNS
    transfers = np.array([modulation_transfer(edge, width) for edge in edges])
    mean = edges.mean(0)
    bright, dark = mean[-COLUMNS // 6 :].mean(), mean[: COLUMNS // 6].mean()
    return BlurRow(
        method=method,
        gap_mm=gap_mm,
        transfer=modulation_transfer(mean, width).tolist(),
        error=(transfers.std(0, ddof=1) / np.sqrt(turns)).tolist(),
        contrast=float((bright - dark) / bright),
    )


def _profiles(sensor: Sensor, state: FrameState, turns: int) -> Array:
    """Brightness of each column in independent images, shape (turns, columns)."""
    view = sensor.view(state, sensor.rest)
    images = [sensor.renderer.plain_radiance(view, turn=turn).astype(np.float64) for turn in range(turns)]
    return np.stack([image.mean((0, 2)) for image in images])


def modulation_transfer(edge: Array, width_mm: float) -> Array:
    """Modulation transfer of an edge-spread function.

    Args:
        edge: Brightness across the edge, which lies in the middle, shape (columns,).
        width_mm: Of a column [mm].

    Returns:
        At `FREQUENCIES_PER_MM`, 1 at zero frequency.
    """
    line = np.diff(edge)
    place = (np.arange(len(line)) - (len(line) - 1) / 2) * width_mm
    # What happens near the ends of the field is not the edge's: a window of two thirds of it fades that out.
    reach = 2 / 3 * place.max()
    line = line * np.where(np.abs(place) < reach, np.cos(np.pi / 2 * place / reach) ** 2, 0.0)
    waves = np.exp(-2j * np.pi * np.outer(FREQUENCIES_PER_MM, place))
    return np.asarray(np.abs(waves @ line) / np.abs(line.sum()))
