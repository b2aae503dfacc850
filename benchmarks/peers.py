"""Beside the peers: what a frame costs, how noisy it is, and how much of an object it shows before and after contact.

Two kinds of them run here: the path-traced opaque gel of `laboratory.opaque_gel`, with the press, lights and camera of
the default sensor, and Taxim, which draws a GelSight from a calibrated table (its own sensor of 640 x 480 pixels; a
ball of the same size, as near and as deep). Without `pip install "taxim[jax-cpu]"` its rows say so.

    python benchmarks/peers.py --out docs/benchmarks        # peers.json and peers.jpg, about six minutes
"""

import argparse
import importlib.util
import json
import time
from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from laboratory.deform.problem import NOT_INSTALLED, machine
from laboratory.light.render_statistics import deviation, spread
from laboratory.opaque_gel import DEPTH, REFLECTANCE, SAMPLES, opaque_scene
from PIL import Image, ImageDraw

from magicsim.camera.exposure import expose, meter
from magicsim.light.backend import mi
from magicsim.light.records.untouched_states import UntouchedStates
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import timeline
from magicsim.simulation.plan import can_touch
from magicsim.simulation.sensor import Sensor

Images = npt.NDArray[np.float32]
SEEDS = 4
INDEPENDENT = ("render.samples=32", "render.particles=800000")
"""Of the images without an anchor that frames of an episode deviate from."""
STATES = ("rest", "near", "pressed")
FAR_MM = 20.0
"""How far away the object of the state `rest` is for Taxim [mm]."""
TAXIM = "Taxim"


def timed(render: Callable[[int], Images]) -> tuple[list[Images], float]:
    """Independent images, and the median seconds of one after a first that compiles."""
    render(0)
    images, seconds = [], []
    for seed in range(1, SEEDS + 1):
        start = time.perf_counter()
        images.append(render(seed))
        seconds.append(time.perf_counter() - start)
    return images, float(np.median(seconds))


def opaque(state: str) -> tuple[dict[str, float], Images]:
    """Cost, noise and picture of the opaque gel in a state."""
    sensor = Sensor.for_scene(load_scene(state, ["design=uniform-block"]))
    body = deformed(sensor)
    scene = opaque_scene(sensor, body if body is not None else sensor.elastomer.body.vertices)

    def render(seed: int) -> Images:
        return np.array(mi.render(scene, spp=SAMPLES, seed=seed), np.float32)

    images, seconds = timed(render)
    return {"seconds": seconds, "relative_noise": spread(images).value}, np.mean(images, axis=0)


def see_through(state: str) -> tuple[dict[str, float], Images]:
    """The same of a frame of the default sensor, anchored as in an episode.

    Its frames share one pattern of camera samples, so that their spread would not be their noise.
    """
    scenes = [load_scene(state, [f"render.anchor_seed={100 + seed}"], seed=seed) for seed in range(SEEDS + 1)]
    sensors = [Sensor.for_scene(scene, untouched=UntouchedStates()) for scene in scenes]
    first = timeline(scenes[0])[0]
    deformation = sensors[0].deform(first, sensors[0].rest) if can_touch(first) else sensors[0].rest
    for sensor in sensors:
        sensor.renderer.metered()
    for sensor in sensors:
        sensor.radiance(sensor.states[0], deformation)

    def render(seed: int) -> Images:
        return sensors[seed].radiance(sensors[seed].states[0], deformation)

    images, seconds = timed(render)
    fine = Sensor.for_scene(load_scene(state, INDEPENDENT))
    view = fine.view(first, deformation)
    independent = [fine.renderer.plain_radiance(view, turn=turn).astype(np.float64) for turn in range(1, SEEDS + 1)]
    error = deviation([image.astype(np.float64) for image in images], independent)
    return {"seconds": seconds, "relative_noise": error.value}, np.mean(images, axis=0)


def taxim(state: str, *, with_shadow: bool) -> tuple[dict[str, float], Images]:
    """Cost and picture of Taxim's GelSight, touched by the same ball as the sensor; it has no noise."""
    from taxim import Taxim  # type: ignore[import-not-found, unused-ignore]

    sensor, first = Taxim(backend="jax"), timeline(load_scene(state))[0]
    radius = load_scene("pressed").object.radius_mm  # type: ignore[union-attr]
    rows, columns = sensor.height, sensor.width
    y, x = ((np.arange(size) - (size - 1) / 2) * sensor.sensor_params.pixmm for size in (rows, columns))
    height = radius - np.sqrt(np.maximum(radius**2 - x**2 - y[:, None] ** 2, 0.0))
    depth = -FAR_MM if first.gap_mm is None else -first.gap_mm

    def render(seed: int) -> Images:
        del seed
        return np.asarray(sensor.render(height.astype(np.float32), with_shadow, depth), np.float32)

    images, seconds = timed(render)
    return {"seconds": seconds, "relative_noise": spread(images).value}, np.mean(images, axis=0)


def deformed(sensor: Sensor) -> npt.NDArray[np.float64] | None:
    """Body vertices in the scene's first state, or None where nothing touches."""
    state = sensor.states[0]
    return sensor.view(state, sensor.deform(state, sensor.rest)).body if can_touch(state) else None


def picture(images: dict[str, Images], scene: SceneConfig) -> Image.Image:
    """What has been rendered near and pressed, side by side, each with the exposure of its untouched image."""
    columns, rows = scene.rig.camera.columns, scene.rig.camera.rows
    frames = {}
    for kind in ("see-through", "opaque gel", TAXIM):
        if f"{kind} rest" not in images:
            continue
        exposure = meter(images[f"{kind} rest"], scene.rig.camera)
        for state in ("near", "pressed"):
            found = images[f"{kind} {state}"]
            drawn = 255 * found if kind == TAXIM else expose(found, exposure, scene.rig.camera, seed=1, frame=0)
            picture = Image.fromarray(np.asarray(drawn).clip(0, 255).astype(np.uint8))
            frames[f"{kind}, {state}"] = picture.rotate(90, expand=True) if kind == TAXIM else picture
    sheet = Image.new("RGB", (len(frames) * (columns + 8) - 8, rows + 24), "white")
    draw = ImageDraw.Draw(sheet)
    for number, (label, frame) in enumerate(frames.items()):
        sheet.paste(frame.resize((columns, rows)), (number * (columns + 8), 24))
        draw.text((number * (columns + 8) + 4, 6), label, fill="black")
    return sheet


def main(out: Path) -> None:
    """Measures all and writes the table and the picture."""
    has_taxim = importlib.util.find_spec("taxim") is not None
    methods: dict[str, Callable[[str], tuple[dict[str, float], Images]]] = {
        "see-through": see_through,
        "opaque gel": opaque,
        TAXIM: partial(taxim, with_shadow=False),
        f"{TAXIM} with shadows": partial(taxim, with_shadow=True),
    }
    rows: list[dict[str, Any]] = []
    images: dict[str, Images] = {}
    for kind, measure in methods.items():
        for state in STATES:
            row: dict[str, Any] = {"method": kind, "state": state, "outcome": "rendered"}
            if kind.startswith(TAXIM) and not has_taxim:
                rows.append(row | {"outcome": NOT_INSTALLED})
                continue
            figures, images[f"{kind} {state}"] = measure(state)
            now, before = images[f"{kind} {state}"], images[f"{kind} rest"]
            change = float(np.sqrt(np.mean((now - before) ** 2 / before.mean((0, 1)) ** 2)))
            rows.append(row | figures | {"change": change, "pixels": now.shape[0] * now.shape[1]})
    out.mkdir(parents=True, exist_ok=True)
    settings = {"samples": SAMPLES, "max_depth": DEPTH, "reflectance": REFLECTANCE, "images": SEEDS}
    found = {
        "results": rows, "opaque_gel": settings, "taxim": version("taxim") if has_taxim else None, "machine": machine(),
    }  # fmt: skip
    table = json.dumps(found, indent=1)
    (out / "peers.json").write_text(table + "\n")
    picture(images, load_scene("rest")).save(out / "peers.jpg", quality=90)
    print(table)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path())
    main(parser.parse_args().out)
