"""Fits a translucent sensor to one real press and predicts two others: `docs/real-frames.json` and its picture.

    python benchmarks/real_frames.py
    python benchmarks/real_frames.py --compare   # SSIM and PSNR of whole frames with the constants of the last fit

The frames in `docs/real-frames` are 9DTact's (MIT). Fitted: scattering, absorption, the coat's reflectance and the
depth of the press, one set of constants for the untouched frame and the pressed one, on rows through the middle of the
contact. Depths in between two that are solved are interpolated. Then the same sensor under two thirds of that depth,
and with a layer thinner by a tenth, is predicted; nothing is compared with that.
"""

import argparse
import json
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from magicsim.deform.deformation import Deformation
from magicsim.fit.constants import CONSTANTS, with_values
from magicsim.light.variant import activate_variant
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor

Array = npt.NDArray[np.float64]
FOLDER = Path("docs/real-frames")
RESULT = FOLDER.parent / "real-frames.json"
WHOLE = ("render.samples=256", "render.particles=2000000")
"""Quality of whole frames: SSIM counts the grain of a rendering as structure."""
MIDDLE_GREY = 128.0
"""What no change is, where the change by the press is compared as an image."""
NAMES = ("gel_scattering", "gel_absorption", "coat_reflectance")
COLUMNS, ROWS, STEP = 92, 69, 5
MIDDLE_PX, PIXEL_MM = (245, 190), 0.0510
FIRST, COUNT = 34, 8
GAPS_MM = (-1.6, -2.0)
START = (0.3, 0.005, 0.1)
ITERATIONS, DAMPING, LEAST_GAIN = 5, 1e-3, 0.02
STRIDE = (np.array([-1, -2, -0.2, -1]), np.array([1, 2, 0.2, 1]))
RANGE = (np.array([-5, np.log(1e-4), 0.0, -0.5]), np.array([3, np.log(0.1), 0.5, 1.5]))
MOST_SHIFT = np.array([0.5, 0.7, 0.1])
HEIGHT_MM, SKIN_MM = 2.8, 0.375
TURNS = 2
EDGES_MM = np.arange(0, 11.6, 0.5)


@dataclass(frozen=True, slots=True, kw_only=True)
class Press:
    """One sensor and the views of its untouched and pressed states."""

    scene: SceneConfig
    deformations: tuple[Deformation, ...]


def observed_whole(name: str) -> Array:
    """Mean grey level of the three channels in blocks of 5 x 5 pixels, shape (69, 92)."""
    image = cv2.imread(str(FOLDER / f"{name}.png")).astype(float)
    return np.asarray(image.reshape(ROWS, STEP, COLUMNS, STEP, 3).mean((1, 3, 4)))


def observed(name: str) -> Array:
    """The strip of `observed_whole`, shape (8, 92)."""
    return observed_whole(name)[FIRST : FIRST + COUNT]


def base_scene(*overrides: str, is_whole: bool = False) -> SceneConfig:
    """The press, of which the camera reads eight rows, or all."""
    camera = [f"rig.camera.columns={COLUMNS}", f"rig.camera.rows={ROWS}", "rig.camera.blur_px=0"]
    if not is_whole:
        camera.append(f"rig.camera.region_px=[0,{FIRST},{COLUMNS},{COUNT}]")
    return load_scene(FOLDER / "9dtact.toml", [*camera, "render.samples=128", "render.particles=300000", *overrides])


def pressed(scene: SceneConfig, gaps_mm: tuple[float, ...]) -> Press:
    """Solves the press at some depths."""
    found = []
    for gap in gaps_mm:
        sensor = Sensor.for_scene(with_values(scene, {"keyframes.*.gap_mm": gap}))
        found.append(sensor.deform(sensor.states[0], sensor.rest))
    return Press(scene=scene, deformations=tuple(found))


def images(press: Press, optics: Array, gaps_mm: tuple[float, ...]) -> list[Array]:
    """Radiance, untouched and at the depths, each of shape (8, 92), or (69, 92) of a whole frame."""
    values: dict[str, object] = dict(zip((CONSTANTS[name].path for name in NAMES), optics.tolist(), strict=True))
    result = []
    sensor = Sensor.for_scene(with_values(press.scene, values))
    state = sensor.states[0]
    views = [sensor.view(UNTOUCHED, sensor.rest), *(sensor.view(state, each) for each in press.deformations)]
    assert len(views) == 1 + len(gaps_mm)
    for view in views:
        turns = [sensor.renderer.plain_radiance(view, turn=turn).mean(2) for turn in range(TURNS)]
        result.append(np.mean(turns, 0, dtype=np.float64))
    return result


def between(found: list[Array], share: float) -> Array:
    """The pressed strip at a share of the way from the first depth to the second."""
    return (1 - share) * found[1] + share * found[2]


def blocks(strip: Array) -> Array:
    """Means of four columns."""
    return np.asarray(strip.mean(0).reshape(-1, 4).mean(1))


def profile(strip: Array) -> Array:
    """Mean over rings about the middle of the contact, shape (rings,)."""
    x = (np.arange(COLUMNS) * STEP + STEP // 2 - MIDDLE_PX[0]) * PIXEL_MM
    y = ((np.arange(COUNT) + FIRST) * STEP + STEP // 2 - MIDDLE_PX[1]) * PIXEL_MM
    radius = np.hypot(*np.meshgrid(x, y))
    rings = [(radius >= low) & (radius < high) for low, high in pairwise(EDGES_MM)]
    return np.array([strip[ring].mean() if ring.any() else np.nan for ring in rings])


def features(drop: Array) -> dict[str, float]:
    """Drop in the middle, height of the bright ring, and radius where the sign changes, of a profile."""
    middles = (EDGES_MM[1:] + EDGES_MM[:-1]) / 2
    first = int(np.argmax(drop < 0))
    crossing = np.interp(0, [-drop[first - 1], -drop[first]], [middles[first - 1], middles[first]])
    return {
        "centre_drop_grey": float(drop[0]),
        "ring_grey": float(-np.nanmin(drop)),
        "crossing_mm": float(crossing),
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """The fitted sensor."""

    point: Array
    """Logarithms of scattering and absorption, reflectance, and share of the way between both depths."""
    sd: Array
    """Standard deviations of these."""
    residuals: Array
    """Of block means, untouched and pressed [grey levels]."""
    strength: float
    """Grey levels for a unit of radiance."""
    found: list[Array]
    """Radiance of the strip, untouched and at both depths."""

    @property
    def optics(self) -> Array:
        """Scattering and absorption [1/mm], and the coat's reflectance."""
        return np.array([np.exp(self.point[0]), np.exp(self.point[1]), self.point[2]])

    @property
    def gap_mm(self) -> float:
        """Of the press [mm]."""
        return float(GAPS_MM[0] + self.point[3] * (GAPS_MM[1] - GAPS_MM[0]))


def fit(press: Press, ref: Array, sample: Array) -> Fit:
    """Levenberg and Marquardt's method on block means of the untouched and the pressed strip."""

    def at(point: Array) -> tuple[Array, list[Array], float]:
        optics = np.array([np.exp(point[0]), np.exp(point[1]), point[2]])
        found = images(press, optics, GAPS_MM)
        strength = float((found[0] * ref).sum() / (found[0] ** 2).sum())
        told = [blocks(strength * found[0] - ref), blocks(strength * between(found, point[3]) - sample)]
        return np.concatenate(told), found, strength

    point = np.array([np.log(START[0]), np.log(START[1]), START[2], 0.5])
    steps = np.array([0.2, 0.4, 0.04, 0.0])
    now, found, strength = at(point)
    damping, jacobian = DAMPING, np.zeros((len(now), 4))
    for iteration in range(ITERATIONS):
        for place in range(3):
            moved = point.copy()
            moved[place] += steps[place]
            jacobian[:, place] = (at(moved)[0] - now) / steps[place]
        change = blocks(strength * (found[2] - found[1]))
        jacobian[:, 3] = np.concatenate([np.zeros_like(change), change])
        matrix = jacobian.T @ jacobian
        step = -np.linalg.solve(matrix + damping * np.diag(np.diag(matrix)), jacobian.T @ now)
        trial = np.clip(point + np.clip(step, *STRIDE), *RANGE)
        later, found_later, strength_later = at(trial)
        rms = [float(np.sqrt(np.mean(each**2))) for each in (now, later)]
        print(iteration, point.round(3).tolist(), rms, trial.round(3).tolist(), flush=True)
        if rms[1] >= rms[0]:
            damping *= 10
            continue
        point, now, found, strength, damping = trial, later, found_later, strength_later, damping / 3
        if rms[0] - rms[1] < LEAST_GAIN * rms[0]:
            break
    variance = np.mean(now**2) * len(now) / (len(now) - 4)
    sd = np.sqrt(np.diag(np.linalg.pinv(jacobian.T @ jacobian)) * variance)
    return Fit(point=point, sd=sd, residuals=now, strength=strength, found=found)


def predict(fitted: Fit, depth_mm: float, *overrides: str) -> tuple[Array, dict[str, dict[str, float]]]:
    """Profile of a press that nobody compared, and its features with their spread over the constants' uncertainty."""
    press, spread, drops = pressed(base_scene(*overrides), (-depth_mm,)), [], []
    for shift in (np.zeros(3), *np.eye(3)):
        moved = shift * np.minimum(fitted.sd[:3], MOST_SHIFT)
        optics = np.array([*fitted.optics[:2] * np.exp(moved[:2]), min(fitted.optics[2] + moved[2], 1.0)])
        seen = images(press, optics, (-depth_mm,))
        drops.append(profile(fitted.strength * float(fitted.found[0].mean() / seen[0].mean()) * (seen[0] - seen[1])))
        spread.append(features(drops[-1]))
    told = {}
    for key, value in spread[0].items():
        off = [each[key] - value for each in spread[1:]]
        told[key] = {"value": value, "sd": float(np.linalg.norm(off))}
    return drops[0], told


def compared(told: dict[str, Any]) -> dict[str, dict[str, float]]:
    """SSIM and PSNR of whole frames in blocks of 5 x 5 pixels, as `skimage.metrics` has them, with fitted constants.

    Args:
        told: What a fit wrote.
    """
    constants = {name: each["value"] for name, each in told["constants"].items()}
    optics = np.array([constants[name] for name in ("sigma_s_per_mm", "absorption_per_mm", "coat_reflectance")])
    gap = (-constants["depth_mm"],)
    press = pressed(base_scene(*WHOLE, is_whole=True), gap)
    seen = [told["strength"] * each for each in images(press, optics, gap)]
    real = [observed_whole("ref"), observed_whole("sample")]
    pairs = {"untouched": (real[0], seen[0]), "pressed": (real[1], seen[1])}
    pairs["change"] = (real[1] - real[0] + MIDDLE_GREY, seen[1] - seen[0] + MIDDLE_GREY)
    return {
        name: {
            "ssim": float(structural_similarity(one, other, data_range=255)),
            "psnr_db": float(peak_signal_noise_ratio(one, other, data_range=255)),
        }
        for name, (one, other) in pairs.items()
    }


def main() -> None:
    """Fits, predicts, writes; or compares whole frames."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--compare", action="store_true", help="only compare whole frames, with the last fit")
    activate_variant()
    if parser.parse_args().compare:
        told = json.loads(RESULT.read_text(encoding="utf-8"))
        RESULT.write_text(json.dumps(told | {"whole_frames": compared(told)}, indent=1) + "\n", encoding="utf-8")
        return
    ref, sample = observed("ref"), observed("sample")
    fitted = fit(pressed(base_scene(), GAPS_MM), ref, sample)
    curves = {
        "observed": profile(ref - sample),
        "fitted": profile(fitted.strength * (fitted.found[0] - between(fitted.found, fitted.point[3]))),
        "reference_observed": profile(ref),
        "reference_fitted": profile(fitted.strength * fitted.found[0]),
    }
    predictions = {}
    thinner = f"design.core_mm={0.9 * HEIGHT_MM - 2 * SKIN_MM:.4f}"
    for name, depth, overrides in (
        ("two thirds of the depth", -fitted.gap_mm * 2 / 3, ()),
        ("layer thinner by a tenth", -fitted.gap_mm, (thinner,)),
    ):
        curves[f"predicted, {name}"], predictions[name] = predict(fitted, depth, *overrides)
    told: dict[str, Any] = _told(fitted, curves) | {"predictions": predictions}
    told["whole_frames"] = compared(told)
    RESULT.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    _plot(curves)


def _told(fitted: Fit, curves: dict[str, Array]) -> dict[str, Any]:
    values = [*fitted.optics.tolist(), -fitted.gap_mm]
    scale = [*fitted.optics[:2].tolist(), 1.0, abs(GAPS_MM[1] - GAPS_MM[0])]
    names = ("sigma_s_per_mm", "absorption_per_mm", "coat_reflectance", "depth_mm")
    constants = zip(names, values, scale, fitted.sd.tolist(), strict=True)
    return {
        "constants": {name: {"value": value, "sd": factor * sd} for name, value, factor, sd in constants},
        "strength": fitted.strength,
        "rms_blocks_grey": float(np.sqrt(np.mean(fitted.residuals**2))),
        "rms_drop_profile_grey": float(np.sqrt(np.nanmean((curves["fitted"] - curves["observed"]) ** 2))),
        "features_observed": features(curves["observed"]),
        "features_fitted": features(curves["fitted"]),
        "radius_mm": ((EDGES_MM[1:] + EDGES_MM[:-1]) / 2).tolist(),
        "curves": {name: np.round(curve, 2).tolist() for name, curve in curves.items()},
    }


def _plot(curves: dict[str, Array]) -> None:
    radius = (EDGES_MM[1:] + EDGES_MM[:-1]) / 2
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
    for name, curve in curves.items():
        axis = axes[1] if name.startswith("reference") else axes[0]
        axis.plot(radius, -curve if axis is axes[0] else curve, "o" if "observed" in name else "-", ms=4, label=name)
    axes[0].set(xlabel="radius from the contact [mm]", ylabel="change by the press [grey levels]")
    axes[1].set(xlabel="radius from the contact [mm]", ylabel="untouched [grey levels]", ylim=(0, 200))
    for axis in axes:
        axis.legend(fontsize=8)
        axis.grid(alpha=0.3)
    figure.savefig(FOLDER.parent / "real-frames.png", dpi=110)


if __name__ == "__main__":
    main()
