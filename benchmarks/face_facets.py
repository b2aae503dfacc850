"""How finely the contact face has to be drawn: error of a touched frame against the length of the face's triangles.

    python benchmarks/face_facets.py [--out docs/benchmarks/face-facets.json]      # some minutes

A punch and a ball are pressed into the default sensor and rendered with faces of ever smaller triangles, the finest of
which stands for a smooth one. Two images of each have random numbers of their own, a and b, so that noise does not
count: error^2 = <(a - A)(b - B)> over pixels, A and B being those of the finest face, in units of the mean.
"""

import argparse
import json
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import timeline
from magicsim.simulation.sensor import Sensor

Image = npt.NDArray[np.float64]
FACETS_MM = (0.5, 0.25, 0.2, 0.1)
TOUCHES = {
    "punch of 3 mm radius, 0.8 mm": ("object={kind='punch',radius_mm=3}", "keyframes=[{frame=0,gap_mm=-0.8}]"),
    "ball of 4 mm radius, 1 mm": ("object={kind='sphere',radius_mm=4}", "keyframes=[{frame=0,gap_mm=-1.0}]"),
}
QUALITY = ("render.samples=16", "render.particles=200000", "render.anchor_samples=0")
SEEDS = (3, 4)


def images(settings: tuple[str, ...], facet_mm: float) -> tuple[list[Image], int, float]:
    """Images with random numbers of their own, triangles of the body, and processor seconds of one."""
    found, seconds = [], 0.0
    for seed in SEEDS:
        scene = load_scene(
            "pressed", [*settings, *QUALITY, f"render.facet_mm={facet_mm}", f"render.anchor_seed={seed}"], seed=seed
        )
        sensor, state = Sensor.for_scene(scene), timeline(scene)[0]
        deformation = sensor.deform(state, sensor.rest)
        sensor.radiance(state, deformation)  # compiles
        start = time.process_time()
        found.append(sensor.radiance(state, deformation).astype(np.float64))
        seconds = time.process_time() - start
    return found, len(sensor.elastomer.body.faces), seconds


def rows() -> Iterator[dict[str, float | str]]:
    """One for each touch and length."""
    for name, settings in TOUCHES.items():
        shown = {facet_mm: images(settings, facet_mm) for facet_mm in FACETS_MM}
        finest = shown[FACETS_MM[-1]][0]
        for facet_mm, (pair, triangles, seconds) in shown.items():
            left = [one - other for one, other in zip(pair, finest, strict=True)]
            square = float((left[0] * left[1]).mean())
            yield {
                "touch": name, "facet_mm": facet_mm, "triangles": triangles, "cpu_seconds": round(seconds, 2),
                "error": round(float(np.sqrt(max(square, 0.0)) / np.mean(finest)), 5),
            }  # fmt: skip


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    found = []
    for row in rows():
        print(json.dumps(row), flush=True)
        found.append(row)
    if chosen.out is not None:
        chosen.out.write_text(json.dumps({"results": found}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
