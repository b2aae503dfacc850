"""Beside an opaque gel: the same press on a painted membrane, path traced as simulators of such sensors do.

The peers' sensors (GelSight, DIGIT) have an opaque membrane, and the public Mitsuba scene of one (Agarwal et al. 2021)
is path traced. This draws a scene of our own of that kind, with the press, the lights and the camera of the default
sensor: only the membrane is seen, diffuse and lit directly and by its neighbourhood. It then tells what each costs,
how noisy it is, and how much of an object that does not touch it shows.

    python benchmarks/opaque_gel.py --out docs/benchmarks        # opaque-gel.json and opaque-gel.jpg, about two minutes
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from magicsim.bench.compare import machine
from magicsim.plan import can_touch
from magicsim.scenes.backend import mi
from magicsim.scenes.exposure import expose, meter
from magicsim.scenes.film import film
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import timeline
from magicsim.scenes.untouched import UntouchedStates
from magicsim.simulation import Sensor

Images = npt.NDArray[np.float32]
SAMPLES = 64
DEPTH = 6
"""Longest path of the opaque gel [interactions]: the membrane lights itself a few times."""
SEEDS = 4
REFLECTANCE = 0.6
"""Of the paint, assumed."""


def membrane(sensor: Sensor, body: npt.NDArray[np.float64]) -> Any:  # noqa: ANN401
    """The contact face of a body as a painted membrane."""
    face = sensor.elastomer.body
    below = face.vertices[:, 2] < 1e-9
    faces = face.faces[below[face.faces].all(1)]
    properties = mi.Properties()
    paint = {"type": "diffuse", "reflectance": {"type": "rgb", "value": REFLECTANCE}}
    properties["bsdf"] = mi.load_dict({"type": "twosided", "bsdf": paint})
    mesh = mi.Mesh("membrane", len(body), len(faces), props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = np.ascontiguousarray(body, np.float32).ravel()
    parameters["faces"] = np.ascontiguousarray(faces, np.uint32).ravel()
    parameters.update()
    return mesh


def opaque_scene(sensor: Sensor, body: npt.NDArray[np.float64]) -> Any:  # noqa: ANN401
    """Membrane, three-coloured strips beside it, and the sensor's camera without refraction."""
    scene, design = sensor.scene, sensor.scene.design
    ideal = film(design, scene.rig)
    width, length = design.footprint_mm
    described: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": DEPTH},
        "membrane": membrane(sensor, body),
        "sensor": {
            "type": "perspective",
            "fov": ideal.fov_deg,
            "fov_axis": "x",
            "to_world": mi.ScalarTransform4f().look_at(
                origin=[0, 0, design.height_mm + scene.rig.camera.distance_mm], target=[0, 0, 0], up=[0, 1, 0]
            ),
            "film": {
                "type": "hdrfilm", "width": ideal.columns, "height": ideal.rows, "pixel_format": "rgb",
                "component_format": "float32", "rfilter": {"type": "box"},
            },
        },
    }  # fmt: skip
    for number, strip in enumerate(scene.rig.strips):
        along = length / 2 if strip.side[1] == "x" else width / 2
        out = np.array([1.0, 0, 0] if strip.side[1] == "x" else [0, 1.0, 0]) * (1 if strip.side[0] == "+" else -1)
        place = out * (width if strip.side[1] == "x" else length) / 2 + [0, 0, design.height_mm / 2]
        turned = mi.ScalarTransform4f().look_at(origin=place.tolist(), target=[0, 0, place[2]], up=[0, 0, 1])
        described[f"strip{number}"] = {
            "type": "rectangle",
            "to_world": turned @ mi.ScalarTransform4f().scale([along, design.height_mm / 4, 1]),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": list(strip.radiance)}},
        }
    # The merge step would order shapes by chance, and with them the random numbers of their light.
    return mi.load_dict(described, optimize=False)


def noise(images: list[Images]) -> float:
    """Root mean square over pixels and channels of the spread between images, in units of each channel's mean."""
    stack = np.array(images, np.float64)
    return float(np.sqrt((stack.var(0, ddof=1) / stack.mean((0, 1, 2)) ** 2).mean()))


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
    sensor = Sensor(load_scene(state, ["design=uniform-block"]))
    body = deformed(sensor)
    scene = opaque_scene(sensor, body if body is not None else sensor.elastomer.body.vertices)

    def render(seed: int) -> Images:
        return np.array(mi.render(scene, spp=SAMPLES, seed=seed), np.float32)

    images, seconds = timed(render)
    return {"seconds": seconds, "relative_noise": noise(images)}, np.mean(images, axis=0)


def see_through(state: str) -> tuple[dict[str, float], Images]:
    """The same of a frame of the default sensor, anchored as in an episode."""
    scenes = [load_scene(state, [f"render.anchor_seed={100 + seed}"], seed=seed) for seed in range(SEEDS + 1)]
    sensors = [Sensor(scene, untouched=UntouchedStates()) for scene in scenes]
    first = timeline(scenes[0])[0]
    deformation = sensors[0].deform(first, sensors[0].rest) if can_touch(first) else sensors[0].rest
    for sensor in sensors:
        sensor.renderer.metered()
    for sensor in sensors:
        sensor.radiance(timeline(sensor.scene)[0], deformation)

    def render(seed: int) -> Images:
        return sensors[seed].radiance(timeline(sensors[seed].scene)[0], deformation)

    images, seconds = timed(render)
    return {"seconds": seconds, "relative_noise": noise(images)}, np.mean(images, axis=0)


def deformed(sensor: Sensor) -> npt.NDArray[np.float64] | None:
    """Body vertices in the scene's first state, or None where nothing touches."""
    state = timeline(sensor.scene)[0]
    return sensor.view(state, sensor.deform(state, sensor.rest)).body if can_touch(state) else None


def picture(images: dict[str, Images], scene: SceneConfig) -> Image.Image:
    """The images side by side, each pair with the exposure of its untouched one."""
    frames = {}
    for kind in ("opaque", "see-through"):
        exposure = meter(images[f"{kind} rest"], scene.rig.camera)
        for state in ("near", "pressed"):
            frames[f"{kind}, {state}"] = expose(images[f"{kind} {state}"], exposure, scene.rig.camera, seed=1, frame=0)
    rows, columns, _ = next(iter(frames.values())).shape
    sheet = Image.new("RGB", (len(frames) * (columns + 8) - 8, rows + 24), "white")
    draw = ImageDraw.Draw(sheet)
    for number, (label, frame) in enumerate(frames.items()):
        sheet.paste(Image.fromarray(frame), (number * (columns + 8), 24))
        draw.text((number * (columns + 8) + 4, 6), label, fill="black")
    return sheet


def main(out: Path) -> None:
    """Measures both and writes the table and the picture."""
    rows: list[dict[str, Any]] = []
    images: dict[str, Images] = {}
    for kind, measure in (("opaque", opaque), ("see-through", see_through)):
        for state in ("rest", "near", "pressed"):
            figures, images[f"{kind} {state}"] = measure(state)
            rows.append({"sensor": kind, "state": state, **figures})
    for row in rows:
        kind = row["sensor"]
        now, before = images[f"{kind} {row['state']}"], images[f"{kind} rest"]
        row["change"] = float(np.sqrt(np.mean((now - before) ** 2 / before.mean((0, 1)) ** 2)))
    out.mkdir(parents=True, exist_ok=True)
    settings = {"samples": SAMPLES, "max_depth": DEPTH, "reflectance": REFLECTANCE, "images": SEEDS}
    table = json.dumps({"results": rows, "opaque_gel": settings, "machine": machine()}, indent=1)
    (out / "opaque-gel.json").write_text(table + "\n")
    picture(images, load_scene("rest")).save(out / "opaque-gel.jpg", quality=90)
    print(table)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path())
    main(parser.parse_args().out)
