"""Error against run time of the light: the fluence estimator and Mitsuba's `volpath` on four states of the sensor.

Every setting renders independent images with seeds of their own; their spread is the error of one of them, and the
time is that of one, everything compiled. Ratios are those of processor seconds, which work beside the benchmark hardly
changes; `seconds` are those of a clock. Neither method is the truth: what their expectations differ by is found from
cross products of independent pairs (`render_statistics`).

`anchored` is a frame of an episode, as `magicsim simulate` renders it: its untouched state, rendered once with care, is
independent from image to image here, and its time is shared by `EPISODE_FRAMES` frames. All such frames share one
pattern of camera samples, so their spread alone would flatter them: their error is the deviation from the mean of the
best images without an anchor.
"""

import json
import logging
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from laboratory.benchmark import machine
from laboratory.light.render_statistics import bias, compare_blocks, deviation, mean_difference, spread
from magicsim.errors import RenderError
from magicsim.light.plain_renderer import central
from magicsim.light.variant import LLVM_VARIANT, SCALAR_VARIANT, VARIANT_VARIABLE, activate_variant
from magicsim.scenes.scene import RenderSettings, load_scene

SCRIPT = Path(__file__).parents[2] / "render.py"
LOGGER = logging.getLogger(__name__)
STATES = ("rest", "near", "pressed", "flashlight")
"""Scenes by name; their first scored frame."""
SEEDS, QUICK_SEEDS = 8, 4
"""Independent images of each setting."""
SMALL_IMAGE = ("rig.camera.columns=120", "rig.camera.rows=160")
"""Camera of a quick benchmark, and of a comparison of both methods alone."""
PARTICLES_A_SAMPLE, PATH_SAMPLES = 25_000, 5
"""Light particles and `volpath` samples of such a comparison, for each camera sample of the fluence estimator."""
AIM = 0.05
"""Relative error at which the fluence estimator's time is reported."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RenderSetting:
    """One point of a curve."""

    estimator: str
    samples: int
    """Camera samples a pixel."""
    particles: int = 100
    """Light particles of all strips together; `path` has none and is given the fewest that are allowed."""
    anchor_samples: int = 0
    """Camera samples a pixel of the untouched state, with `ANCHOR_PARTICLES` for each; 0 without an anchor."""


class Timed(NamedTuple):
    """An image, and the time that it took."""

    image: np.ndarray
    """Radiance, shape (rows, columns, 3)."""
    seconds: float
    """Time by a clock [s]."""
    cpu_seconds: float
    """Time of all threads of the process [s]."""


FLUENCE = tuple(
    RenderSetting(estimator="fluence", samples=samples, particles=particles)
    for samples, particles in ((2, 50_000), (4, 100_000), (8, 200_000), (16, 400_000), (32, 800_000))
)
PATH = tuple(RenderSetting(estimator="path", samples=samples) for samples in (1, 4, 16))
SCALAR = (RenderSetting(estimator="path", samples=1),)
"""Settings that run without LLVM."""
UNTOUCHED_STATE = "rest"
"""State whose frames cost an episode nothing but the anchor."""
DEFAULT = RenderSettings()
ANCHORED = tuple(
    RenderSetting(estimator="anchored", samples=samples, particles=particles, anchor_samples=anchor)
    for samples, particles, anchor in (
        (DEFAULT.samples, DEFAULT.particles, DEFAULT.anchor_samples), (8, 80_000, 32), (16, 200_000, 64)
    )
)  # fmt: skip
"""The default of a scene, and finer ones for pressed frames."""
ANCHOR_PARTICLES = 37_500
"""Light particles of all strips for each camera sample of the untouched state, as by default."""
EPISODE_FRAMES = 100
"""Frames that share the time of one anchor."""
QUICK = (FLUENCE[1], FLUENCE[2], PATH[0], PATH[1])


def run_render(*, quick: bool = False, states: Sequence[str] = STATES) -> dict[str, Any]:
    """Runs every state in a process of its own, and `rest` once more without LLVM.

    Args:
        quick: One state, few settings and a small image.
        states: Names of scenes.

    Returns:
        The object that the plot is drawn from: `results`, `comparison`, `equal_error`, `seconds_at`, `machine`.
    """
    chosen = states[:1] if quick else states
    parts = [_in_own_process(state, quick=quick, variant=activate_variant()) for state in chosen]
    if not quick and activate_variant() == LLVM_VARIANT:
        parts.append(_in_own_process(chosen[0], quick=quick, variant=SCALAR_VARIANT))
    return {
        "kind": "render",
        "quick": quick,
        "results": [row for part in parts for row in part["results"]],
        "comparison": [part["comparison"] for part in parts if part["comparison"] is not None],
        "equal_error": [row for part in parts for row in equal_error(part["results"])],
        "seconds_at": {part["results"][0]["state"]: seconds_at(part["results"], AIM) for part in parts[: len(chosen)]},
        "aim": AIM,
        "machine": machine(),
    }


def measure_state(
    state: str, *, quick: bool, first_seed: int = 1, only: Sequence[RenderSetting] = (), overrides: Sequence[str] = ()
) -> dict[str, Any]:
    """All settings on one state, with this process's variant.

    Args:
        state: Name of a scene.
        quick: Few settings and a small image.
        first_seed: Of each setting's images.
        only: Settings instead of these.
        overrides: `dotted.key=value` settings of the scene.
    """
    variant = activate_variant()
    settings = QUICK if quick else (*FLUENCE, *(() if state == UNTOUCHED_STATE else ANCHORED), *PATH)
    settings = tuple(only) or (settings if variant == LLVM_VARIANT else SCALAR)
    count = QUICK_SEEDS if quick else SEEDS
    seeds = range(first_seed, first_seed + count)
    sized = [*(SMALL_IMAGE if quick or only else ()), *overrides]
    found = {setting: _render(state, setting, seeds, sized) for setting in settings}
    best = {
        estimator: max((each for each in found if each.estimator == estimator), key=lambda each: each.samples)
        for estimator in {each.estimator for each in found}
    }
    independent = [each.image for each in found[best.get("fluence", best["path"])]]
    reference = np.mean(independent, axis=0)
    rows = []
    for setting, frames in found.items():
        images = [each.image for each in frames]
        error = deviation(images, independent) if setting in ANCHORED else spread(images)
        rows.append(
            {"state": state, "variant": variant, **asdict(setting), "seeds": count,
             "seconds": float(np.median([each.seconds for each in frames])),
             "cpu_seconds": float(np.median([each.cpu_seconds for each in frames])),
             "error": error.value, "error_of_error": error.error,
             "flip": flip(images[0], reference) if setting not in best.values() else None,
             "mean": np.mean(images, axis=(0, 1, 2)).tolist()}
        )  # fmt: skip
        LOGGER.info("%s, %s: %.3f in %.2f s", state, setting, error.value, rows[-1]["seconds"])
    comparison = None
    if {"fluence", "path"} <= best.keys():
        ours, theirs = ([each.image for each in found[best[name]]] for name in ("fluence", "path"))
        comparison = {
            "state": state, "mean_difference": [asdict(one) for one in mean_difference(ours, theirs)],
            "bias": asdict(bias(ours, theirs)), "blocks": asdict(compare_blocks(ours, theirs)),
        }  # fmt: skip
    return {"results": rows, "comparison": comparison}


def equal_error(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Seconds of the methods at the same errors: `path`'s extrapolated by samples^-1/2 from its longest run.

    Args:
        rows: Results of one state and variant.
    """
    paths = [row for row in rows if row["estimator"] == "path"]
    ours = [row for row in rows if row["estimator"] != "path"]
    if not paths or not ours:
        return []
    longest = max(paths, key=lambda row: row["samples"])
    return [
        {"state": row["state"], "estimator": row["estimator"], "error": row["error"], "seconds": row["seconds"],
         "path_seconds": longest["seconds"] * (times := (longest["error"] / row["error"]) ** 2),
         "ratio": longest["cpu_seconds"] * times / row["cpu_seconds"]}
        for row in ours
    ]  # fmt: skip


def seconds_at(rows: Sequence[dict[str, Any]], error: float) -> float | None:
    """Seconds of the fluence estimator at an error, along the power law of its settings.

    Args:
        rows: Results of one state and variant.
        error: Relative error.
    """
    ours = [row for row in rows if row["estimator"] == "fluence"]
    if len(ours) < 2:  # a line needs two points
        return None
    errors, seconds = np.log([row["error"] for row in ours]), np.log([row["seconds"] for row in ours])
    exponent, constant = np.polyfit(errors, seconds, 1)
    return float(np.exp(constant + exponent * np.log(error)))


def flip(image: np.ndarray, reference: np.ndarray) -> float | None:
    """Mean FLIP of the exposed image, 0 to 1; None where the package `flip-evaluator` is not installed."""
    try:
        import flip_evaluator
    except ModuleNotFoundError:
        return None
    gain = 90 / 255 / reference.mean()
    ours, truth = (np.clip(central(each) * gain, 0, 1).astype(np.float32) for each in (image, reference))
    found = flip_evaluator.evaluate(truth, ours, "LDR", inputsRGB=False, applyMagma=False)
    return float(found[1])


def both(samples: int) -> tuple[RenderSetting, RenderSetting]:
    """Settings that compare the two methods, at noises that are alike.

    Args:
        samples: Of the fluence estimator; `volpath` has more.
    """
    particles = PARTICLES_A_SAMPLE * samples
    return (
        RenderSetting(estimator="fluence", samples=samples, particles=particles),
        RenderSetting(estimator="path", samples=PATH_SAMPLES * samples),
    )


def _render(state: str, setting: RenderSetting, seeds: range, size: Sequence[str]) -> list[Timed]:
    from magicsim.scenes.timeline import timeline
    from magicsim.simulation.sensor import Sensor

    if setting.estimator == "anchored":
        return _render_anchored(state, setting, seeds, size)
    scene = load_scene(
        state,
        [f"render.estimator={setting.estimator}", f"render.samples={setting.samples}",
         f"render.particles={setting.particles}", *size],
        seed=0,
    )  # fmt: skip
    sensor, frame = Sensor.for_scene(scene), timeline(scene)[0]
    deformation = sensor.deform(frame, sensor.rest) if frame.can_touch else sensor.rest
    view = sensor.view(frame, deformation)
    sensor.renderer.plain_radiance(view)  # compiles
    frames = []
    for turn in seeds:
        start = _now()
        image = sensor.renderer.plain_radiance(view, turn=turn)
        frames.append(Timed(image.astype(np.float64), *(_now() - start)))
    return frames


def _now() -> np.ndarray:
    """Seconds of a clock and of the processor."""
    return np.array([time.perf_counter(), time.process_time()])


def _render_anchored(state: str, setting: RenderSetting, seeds: range, size: Sequence[str]) -> list[Timed]:
    from magicsim.scenes.timeline import UNTOUCHED, timeline
    from magicsim.simulation.sensor import Sensor

    frames = []
    for turn in (0, *seeds):
        settings = [
            f"render.samples={setting.samples}", f"render.particles={setting.particles}",
            f"render.anchor_samples={setting.anchor_samples}",
            f"render.anchor_particles={ANCHOR_PARTICLES * setting.anchor_samples}",
            f"render.anchor_seed={1000 + turn}", *size,
        ]  # fmt: skip
        scene = load_scene(state, settings, seed=turn)
        sensor, frame = Sensor.for_scene(scene), timeline(scene)[0]
        view = sensor.view(frame, sensor.deform(frame, sensor.rest) if frame.can_touch else sensor.rest)
        sensor.renderer.warm_up(sensor.view(UNTOUCHED, sensor.rest))
        sensor.renderer.warm_up(view)
        start = _now()
        sensor.renderer.prepare(view)
        middle = _now()
        image = sensor.renderer.radiance(view)
        spent = _now() - middle + (middle - start) / EPISODE_FRAMES
        frames.append(Timed(image.astype(np.float64), *spent))
    return frames[1:]  # the first one compiles


def _in_own_process(state: str, *, quick: bool, variant: str) -> dict[str, Any]:
    command = [sys.executable, str(SCRIPT), state, *(["--quick"] if quick else [])]
    done = subprocess.run(
        command, stdout=subprocess.PIPE, text=True, check=False, env=os.environ | {VARIANT_VARIABLE: variant}
    )
    if done.returncode:
        msg = f"the benchmark of state '{state}' with {variant} ended with code {done.returncode}"
        raise RenderError(msg)
    found: dict[str, Any] = json.loads(done.stdout)
    return found
