"""How much a touch changes the light in the block, what a frame's particles measure of it, and what is kept of that.

    python benchmarks/touch_light.py [--out touch-light.json] [--particles 960000] [--draws 6]

For each object: the relative change of the fluence from just before contact to the touch, by many particles, weighted
by the fluence of the cells, which is the error of leaving it out; how large it is expected to be, which decides on that
(`render.light_change`); the noise of a frame's own particles in local means over two cells; and the error of what
`anchored_light` makes of it, with the expected size of a change and without; and that of what a block without walls
says (`laboratory/light/wall_less.py`), whose particles bring noise from the dent alone. Root mean squares of changes
and errors are products of two independent sets of many particles, so that their noise adds nothing in the mean.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from laboratory.light.wall_less import touch_change
from scipy.ndimage import gaussian_filter

from magicsim.light.frame.anchored_light import (
    CHANGED_SHARE,
    SMOOTHING_CELLS,
    Counts,
    Expected,
    anchored_light,
    contact_share,
)
from magicsim.light.frame.frame_light import lifted
from magicsim.light.transport.light_field import LightField, total
from magicsim.light.world.names import ENVIRONMENT
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import FrameState, View
from magicsim.simulation.sensor import Sensor

Array = npt.NDArray[np.float64]
TOUCHES = {
    "ball, 0.06 mm": (-0.06, ()),
    "ball, 0.5 mm": (-0.5, ()),
    "ball, 1 mm": (-1.0, ()),
    "ball, 1.5 mm": (-1.5, ()),
    "ball of 25 mm, 0.5 mm": (-0.5, ("object={kind='sphere',radius_mm=25}",)),
    "box of 7 mm, 0.5 mm": (-0.5, ("object={kind='box',size_mm=[7,7,10]}",)),
    "box on all of the face, 0.1 mm": (-0.1, ("object={kind='box',size_mm=[40,50,10]}",)),
}
WALL_LESS = 100_000
"""Particles of each strip in a block without walls."""
FIRST_SEED = 900
"""Seed of the many particles, apart from those of the draws."""


def mean_field(fluence: Array, counts: Counts) -> Array:
    """Local means of the fluence, shape (cells, 3)."""
    grid = fluence.reshape(*counts[::-1], 3)
    return gaussian_filter(grid, (SMOOTHING_CELLS[0],) * 3 + (0,), mode="nearest", truncate=2.5).reshape(-1, 3)


def rms(first: Array, second: Array, level: Array) -> float:
    """Root mean square over cells and channels, weighted by the level, of what two samples have in common."""
    return float(np.sqrt(max(0.0, (level * first * second).sum() / level.sum())))


def measured(gap_mm: float, overrides: tuple[str, ...], *, particles: int, draws: int) -> dict[str, Any]:
    """One row: how large the change is, its noise, the error of what is kept."""
    press = f"keyframes=[{{frame=0,gap_mm={gap_mm},x_mm=1.0,y_mm=0.5}}]"
    sensor = Sensor.for_scene(load_scene("near", [press, *overrides], seed=1))
    state = FrameState(gap_mm=gap_mm, x_mm=1.0, y_mm=0.5, twist_deg=0.0, flashlight=False, light_x_mm=0.0)
    deformation = sensor.deform(state, sensor.rest)
    renderer, view = sensor.renderer, sensor.view(state, deformation)
    rest, touched, placed = renderer.light(View()), renderer.light(view), renderer.placed(view)
    outside, shares = renderer.outside(lifted(placed), None), rest.shares(sensor.settings.particles)
    own = sum(count for name, count in shares.items() if name != ENVIRONMENT)
    many = {name: count * particles // own for name, count in shares.items()}

    def light(count: dict[str, int], seed: int) -> tuple[Array, Array]:
        after = total(list(touched.light_fields(count, seed=seed).values())).fluence
        before = total(list(rest.light_fields(count, seed=seed, outside=outside).values())).fluence
        return after, before

    counts, truths, levels = rest.counts, [], []
    for turn in range(2):
        after, before = (mean_field(each, counts) for each in light(many, FIRST_SEED + turn))
        truths.append(after / before - 1)
        levels.append(before)
    careful = light(many, FIRST_SEED + 2)[1]
    level, known = (levels[0] + levels[1]) / 2, mean_field(careful, counts)
    contact = renderer.contact(placed)
    share = contact_share(rest.inventory.centres_mm(), contact.vertices, contact.faces)
    size = Expected(cells=share, voxels=np.ones(1))
    kept: dict[str, list[float]] = {"noise": [], "kept": [], "all": [], "wall-less": []}
    albedo = float(np.mean(sensor.object.color))
    for seed in range(draws):
        now, cheap = light(shares, seed)
        noise = mean_field(cheap, counts) / level - 1
        kept["noise"].append(rms(noise, noise, level) ** 2)
        for name, expected in (("kept", size), ("all", None)):
            fields = [[only(each, channel) for each in (now, cheap, careful)] for channel in range(3)]
            found = total([anchored_light(*each, counts, None, expected=expected) for each in fields]).fluence
            wrong = [mean_field(found, counts) / known - 1 - truth for truth in truths]
            kept[name].append(rms(wrong[0], wrong[1], level) ** 2)
        more = touch_change(sensor, state, deformation, particles=WALL_LESS, seed=seed, albedo=albedo)
        said = mean_field(careful * (1 + more), counts) / known - 1
        kept["wall-less"].append(rms(said - truths[0], said - truths[1], level) ** 2)
    errors = {name: float(np.sqrt(np.mean(squares))) for name, squares in kept.items()}
    change = rms(truths[0], truths[1], level)
    return {
        "particles": own,
        "mean_change": ((level * (truths[0] + truths[1]) / 2).sum(0) / level.sum(0)).tolist(),
        "expected_change": size.size(careful),
        "error_left_out": change,
        "change_over_share": change * CHANGED_SHARE / size.size(careful),
        "noise_of_frame": errors["noise"],
        "error_expected": errors["kept"],
        "error_all": errors["all"],
        "error_wall_less": errors["wall-less"],
    }


def only(fluence: Array, channel: int) -> LightField:
    """One channel of a field, dark in the others, as frames tell light apart."""
    return LightField(fluence=fluence * np.eye(3)[channel], body=np.zeros((1, 3)), irradiance=np.zeros((1, 3)))


def main() -> None:
    """Prints the table and keeps it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("touch-light.json"))
    parser.add_argument("--particles", type=int, default=960_000)
    parser.add_argument("--draws", type=int, default=6)
    arguments = parser.parse_args()
    found = {
        name: measured(gap_mm, overrides, particles=arguments.particles, draws=arguments.draws)
        for name, (gap_mm, overrides) in TOUCHES.items()
    }
    for name, row in found.items():
        print(f"{name}: mean change {', '.join(f'{100 * each:.2f}' for each in row['mean_change'])} %")
        for key, value in row.items():
            if isinstance(value, float):
                print(f"    {key:22s} {100 * value:.2f} %")
    arguments.out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
