"""Fits a translucent sensor to one real press and predicts two others: `docs/real-frames.json` and its pictures.

    python benchmarks/real_frames.py             # all stages
    python benchmarks/real_frames.py fit         # fits again to the renderings of docs/real-frames/renders.json
    python benchmarks/real_frames.py confirm     # whole frames with the constants of the last fit: curves, SSIM, PSNR

The frames in `docs/real-frames` are 9DTact's (MIT). Fitted: scattering, absorption, the coat's reflectance, the radius
of the ring of light and the depth of the press, and of the camera vignetting, exposure and gamma (or none), one set for
the untouched frame and the pressed one, on mean levels of rings about the middle of the contact. `render` makes both
frames at places of a Latin hypercube over the constants and at four depths; `fit` smooths the logarithms of their
rings with polynomials, which takes the noise of single renderings out of it, solves for the constants, and does so
again with polynomials that go through a careful rendering of what was found. `confirm` renders anew: all curves,
residuals and comparisons are of these renderings, whose exposure is metered on the untouched frame. `predict` renders
two thirds of that depth and a layer thinner by a tenth; nothing is compared with that.
"""

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares
from scipy.stats import qmc
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from magicsim.config.models import validate
from magicsim.fit.constants import CONSTANTS, with_values
from magicsim.light.variant import activate_variant
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor

Array = npt.NDArray[np.float64]
FOLDER = Path("docs/real-frames")
RENDERS, RESULT = FOLDER / "renders.json", FOLDER.parent / "real-frames.json"
COLUMNS, ROWS, STEP = 92, 69, 5
MIDDLE_PX, PIXEL_MM = (245, 190), 0.0510
EDGES_MM = np.arange(0, 11.6, 0.5)
MIDDLES_MM = (EDGES_MM[1:] + EDGES_MM[:-1]) / 2
MIDDLE_GREY = 128.0
"""What no change is, where the change by the press is compared as an image."""
RANGES = {
    "gel_scattering": (np.log(0.08), np.log(0.8)), "gel_absorption": (np.log(1e-4), np.log(0.03)),
    "coat_reflectance": (0.0, 0.3), "ring_radius": (9.0, 17.0),
}  # fmt: skip
"""Constants that are rendered, logarithms of the first two [1/mm, 1/mm, 1, mm]; the least absorption does nothing."""
LOGARITHMS = 2
GAPS_MM = (-1.3, -1.5, -1.7, -1.9)
DEPTH_MM = (1.2, 2.0)
POINTS, SEED = 20, 3
SKETCH = ("render.samples=64", "render.particles=2000000")
CAREFUL = ("render.samples=256", "render.particles=4000000")
SHOWN = ("render.samples=1024", "render.particles=4000000")
"""Quality of renderings that are fitted, of predictions, and of what is shown: SSIM takes grain for structure."""
TURNS = 2
GAMMA, VIGNETTING = (1.0, 2.4), (0.0, 0.6)
STARTS = 6
CORE_MM, SKIN_MM = 1.75, 0.375
THINNER = f"design.core_mm={0.9 * (CORE_MM + 2 * SKIN_MM) - 2 * SKIN_MM:.4f}"
SHIFT = 0.2
"""Of a constant, in units of half its range, from which predictions take derivatives."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Constants:
    """One sensor, one press, one camera."""

    scattering_per_mm: float
    absorption_per_mm: float
    coat_reflectance: float
    ring_radius_mm: float
    depth_mm: float
    vignetting: float
    """Loss at the corners of the picture."""
    exposure: float
    """Logarithm of the signal (1 is white) of a unit of radiance."""
    gamma: float
    """Of the tone curve: grey = 255 signal^(1 / gamma)."""

    @property
    def rendered(self) -> Array:
        """What a rendering depends on, as in `RANGES`."""
        return np.array(
            [np.log(self.scattering_per_mm), np.log(self.absorption_per_mm), self.coat_reflectance, self.ring_radius_mm]
        )


def from_vector(vector: Array) -> Constants:
    """The constants of a vector: logarithms of the first two."""
    first = [*np.exp(vector[:LOGARITHMS]), *vector[LOGARITHMS:]]
    return Constants(**dict(zip(Constants.__dataclass_fields__, map(float, first), strict=True)))


def observed(name: str) -> Array:
    """Mean grey level of the three channels in blocks of 5 x 5 pixels, shape (69, 92)."""
    image = cv2.imread(str(FOLDER / f"{name}.png")).astype(float)
    return np.asarray(image.reshape(ROWS, STEP, COLUMNS, STEP, 3).mean((1, 3, 4)))


def profile(frame: Array) -> Array:
    """Mean over rings about the middle of the contact, shape (rings,)."""
    x = (np.arange(COLUMNS) * STEP + STEP // 2 - MIDDLE_PX[0]) * PIXEL_MM
    y = (np.arange(ROWS) * STEP + STEP // 2 - MIDDLE_PX[1]) * PIXEL_MM
    radius = np.hypot(*np.meshgrid(x, y))
    return np.array([frame[(radius >= low) & (radius < high)].mean() for low, high in pairwise(EDGES_MM)])


def shade(vignetting: float) -> Array:
    """What the lens lets pass, as `rig.camera.vignetting` has it, shape (69, 92)."""
    x, y = np.meshgrid(np.arange(COLUMNS) - (COLUMNS - 1) / 2, np.arange(ROWS) - (ROWS - 1) / 2)
    return np.asarray(1 - vignetting * (x**2 + y**2) / ((COLUMNS**2 + ROWS**2) / 4))


def grey(radiance: Array, camera: Constants, shading: Array) -> Array:
    """Grey levels of radiances, both of the shape of `shading`."""
    return np.asarray(255 * np.clip(np.exp(camera.exposure) * radiance * shading, 0, 1) ** (1 / camera.gamma))


def press_scene(gaps_mm: Sequence[float], *overrides: str) -> SceneConfig:
    """The press at some depths, one keyframe each, so that all are on one lattice."""
    camera = (f"rig.camera.columns={COLUMNS}", f"rig.camera.rows={ROWS}", "rig.camera.blur_px=0")
    data = load_scene(FOLDER / "9dtact.toml", [*camera, *overrides]).model_dump(mode="json")
    (first,) = data["keyframes"]
    data["keyframes"] = [{**first, "frame": number, "gap_mm": gap} for number, gap in enumerate(gaps_mm)]
    return validate(SceneConfig, data, source="the real press")


def solved(scene: SceneConfig) -> list[Any]:
    """Equilibria of a scene's keyframes."""
    sensor = Sensor.for_scene(scene)
    found = [sensor.rest]
    for state in sensor.states:
        found.append(sensor.deform(state, found[-1]))
    return found


def images(scene: SceneConfig, solution: list[Any], rendered: Array, *, turns: int = 1) -> Array:
    """Radiance, untouched and in each state, shape (states + 1, 69, 92)."""
    values = [*np.exp(rendered[:LOGARITHMS]), *rendered[LOGARITHMS:]]
    paths = [CONSTANTS[name].path for name in RANGES]
    sensor = Sensor.for_scene(with_values(scene, dict(zip(paths, map(float, values), strict=True))))
    views = [sensor.view(state, each) for state, each in zip((UNTOUCHED, *sensor.states), solution, strict=True)]
    return np.array(
        [
            np.mean([sensor.renderer.plain_radiance(view, turn=turn).mean(2) for turn in range(turns)], 0)
            for view in views
        ],
        np.float64,
    )


def places() -> Array:
    """Rendered constants of the Latin hypercube, shape (points, 4)."""
    low, high = np.array(list(RANGES.values())).T
    return np.asarray(qmc.scale(qmc.LatinHypercube(len(RANGES), rng=SEED).random(POINTS), low, high))


def render(some: Sequence[int]) -> list[list[list[float]]]:
    """Rings of radiance at some places, untouched and at every depth; shape (places, 5, rings)."""
    scene = press_scene(GAPS_MM, *SKETCH)
    solution, points, found = solved(scene), places(), []
    for number in some:
        found.append([profile(each).round(6).tolist() for each in images(scene, solution, points[number])])
        print("rendered", number, flush=True)
    return found


class Rings:
    """Smooth rings of radiance over constants and depth, from renderings."""

    def __init__(self, points: Array, renders: Array) -> None:
        """Fits the logarithms.

        Args:
            points: Rendered constants, shape (points, 4).
            renders: Rings, shape (points, 5, rings).
        """
        basis = np.array([self._basis(point) for point in points])
        self.rest, *_ = np.linalg.lstsq(basis, np.log(renders[:, 0]), rcond=None)
        depths = np.array([self._depths(-gap) for gap in GAPS_MM])
        both = np.einsum("pb,gd->pgbd", basis, depths).reshape(len(points) * len(GAPS_MM), -1)
        ratio = np.log(renders[:, 1:] / renders[:, :1]).reshape(len(both), -1)
        self.change, *_ = np.linalg.lstsq(both, ratio, rcond=None)
        self.correction = np.ones((2, renders.shape[2]))

    @staticmethod
    def _basis(point: Array) -> Array:
        low, high = np.array(list(RANGES.values())).T
        s, a, c, r = (2 * point - low - high) / (high - low)
        return np.array([1, s, s * s, a, s * a, c, c * c, s * c, r, s * r])

    @staticmethod
    def _depths(depth_mm: float) -> Array:
        u = (depth_mm - np.mean(DEPTH_MM)) / np.ptp(DEPTH_MM) * 2
        return np.array([1, u, u * u])

    def of(self, constants: Constants) -> tuple[Array, Array]:
        """Untouched and pressed radiance in rings."""
        basis = self._basis(constants.rendered)
        rest = np.exp(basis @ self.rest)
        change = np.exp(np.outer(basis, self._depths(constants.depth_mm)).ravel() @ self.change)
        return rest * self.correction[0], rest * change * self.correction[1]

    def correct(self, constants: Constants, rendered: Array) -> None:
        """Goes through a rendering from now on, untouched and pressed, shape (2, rings); its neighbours move along."""
        self.correction = self.correction * rendered / np.array(self.of(constants))


def fit(rings: Rings, real: Array, *, gamma: float | None) -> tuple[Constants, dict[str, float], Array, float]:
    """Least squares on rings of both frames.

    Args:
        rings: Of the model.
        real: Observed, shape (2, rings).
        gamma: Of the camera; None to fit it.

    Returns:
        Constants, their standard deviations, their covariance (of a vector as in `from_vector`), and the root mean
        square of the residuals [grey levels].
    """

    def residuals(vector: Array) -> Array:
        constants = from_vector(vector)
        shading = profile(shade(constants.vignetting))
        return np.concatenate(
            [grey(each, constants, shading) - seen for each, seen in zip(rings.of(constants), real, strict=True)]
        )

    held = (gamma - 1e-6, gamma + 1e-6) if gamma is not None else GAMMA
    bounds = np.array([*RANGES.values(), DEPTH_MM, VIGNETTING, (-8.0, 12.0), held]).T
    random, best = np.random.default_rng(SEED), None
    for _ in range(STARTS):
        start = bounds[0] + random.uniform(0.2, 0.8, bounds.shape[1]) * np.ptp(bounds, axis=0)
        rest = rings.of(from_vector(start))[0].mean()
        start[6] = start[7] * np.log(real[0].mean() / 255) - np.log(rest)
        found = least_squares(residuals, start, bounds=bounds, x_scale=np.ptp(bounds, axis=0))
        best = found if best is None or found.cost < best.cost else best
    count = len(best.fun) - (bounds.shape[1] - (gamma is not None))
    free = np.array([True] * 7 + [gamma is None])
    covariance = np.zeros((len(free), len(free)))
    jacobian = best.jac[:, free]
    covariance[np.ix_(free, free)] = np.linalg.pinv(jacobian.T @ jacobian) * (best.fun**2).sum() / count
    constants = from_vector(best.x)
    spread = np.sqrt(np.diag(covariance))
    values = list(asdict(constants).values())
    spread[:LOGARITHMS] *= values[:LOGARITHMS]
    sds = dict(zip(asdict(constants), spread.tolist(), strict=True))
    return constants, sds, covariance, float(np.sqrt(np.mean(best.fun**2)))


def features(drop: Array) -> dict[str, float]:
    """Drop in the middle, height of the bright ring, and radius where the sign changes, of a profile."""
    first = int(np.argmax(drop < 0))
    crossing = np.interp(0, [-drop[first - 1], -drop[first]], [MIDDLES_MM[first - 1], MIDDLES_MM[first]])
    return {
        "centre_drop_grey": float(drop[0]),
        "ring_grey": float(-np.nanmin(drop)),
        "crossing_mm": float(crossing),
    }


def radiance(constants: Constants, *overrides: str, turns: int = TURNS) -> Array:
    """Whole frames, untouched and pressed, rendered with some constants, shape (2, 69, 92).

    Args:
        constants: Of sensor and press.
        overrides: Of the scene.
        turns: Renderings whose mean is taken.
    """
    scene = press_scene((-constants.depth_mm,), *overrides)
    return images(scene, solved(scene), constants.rendered, turns=turns)


def confirm(constants: Constants) -> dict[str, Any]:
    """Curves, what is left over, comparisons of whole frames, pictures; exposure is metered on the untouched one."""
    real = np.array([observed("ref"), observed("sample")])
    found, shading = radiance(constants, *SHOWN), shade(constants.vignetting)
    level = profile(real[0]).mean() / profile(grey(found[0], constants, shading)).mean()
    constants = replace(constants, exposure=constants.exposure + constants.gamma * float(np.log(level)))
    seen = grey(found, constants, shading)
    rings = {name: np.array([profile(each) for each in pair]) for name, pair in (("real", real), ("seen", seen))}
    drops = {name: each[0] - each[1] for name, each in rings.items()}
    pairs = dict(zip(("untouched", "pressed"), zip(real, seen, strict=True), strict=True))
    pairs["change"] = (real[1] - real[0] + MIDDLE_GREY, seen[1] - seen[0] + MIDDLE_GREY)
    _draw(pairs)
    return {
        "exposure": constants.exposure,
        "rms_profiles_grey": float(np.sqrt(np.mean((rings["seen"] - rings["real"]) ** 2))),
        "rms_change_profile_grey": float(np.sqrt(np.mean((drops["seen"] - drops["real"]) ** 2))),
        "rms_blocks_grey": float(np.sqrt(np.mean((seen - real) ** 2))),
        "features_observed": features(drops["real"]),
        "features_fitted": features(drops["seen"]),
        "radius_mm": MIDDLES_MM.tolist(),
        "curves": {
            "observed": drops["real"].round(2).tolist(), "fitted": drops["seen"].round(2).tolist(),
            "untouched, observed": rings["real"][0].round(2).tolist(),
            "untouched, fitted": rings["seen"][0].round(2).tolist(),
        },
        "whole_frames": {
            name: {
                "ssim": float(structural_similarity(one, other, data_range=255)),
                "psnr_db": float(peak_signal_noise_ratio(one, other, data_range=255)),
            }
            for name, (one, other) in pairs.items()
        },
    }  # fmt: skip


def predict(constants: Constants, covariance: Array, depth_share: float, *overrides: str) -> dict[str, Any]:
    """A press that nobody compared: its profile, and features with their spread by the constants' covariance."""
    low, high = np.array([*RANGES.values(), DEPTH_MM]).T
    base = press_scene((-constants.depth_mm,), *CAREFUL)
    exposed = images(base, [Sensor.for_scene(base).rest] * 2, constants.rendered)[0].mean()

    def at(vector: Array) -> Array:
        moved = from_vector(vector)
        moved = replace(moved, depth_mm=depth_share * moved.depth_mm)
        found = radiance(moved, *CAREFUL, *overrides, turns=1)
        frames = grey(found * exposed / found[0].mean(), constants, shade(constants.vignetting))
        return profile(frames[0]) - profile(frames[1])

    middle = np.array([*constants.rendered, *list(asdict(constants).values())[4:]])
    drop = at(middle)
    value, slopes = features(drop), []
    for place in range(len(low)):
        step = SHIFT * (high - low)[place] / 2
        step = -step if middle[place] + step > high[place] else step
        moved = middle.copy()
        moved[place] += step
        slopes.append({key: (each - value[key]) / step for key, each in features(at(moved)).items()})
    cut = covariance[: len(low), : len(low)]
    told = {}
    for key, each in value.items():
        slope = np.array([one[key] for one in slopes])
        told[key] = {"value": each, "sd": float(np.sqrt(slope @ cut @ slope))}
    return {"features": told, "curve": drop.round(2).tolist()}


def main() -> None:
    """Runs the stages."""
    stages = ("render", "fit", "confirm", "predict")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stages", nargs="*", help=f"of {', '.join(stages)}; all without")
    asked = parser.parse_args().stages or stages
    if not set(asked) <= set(stages):
        parser.error(f"unknown stage; there are {', '.join(stages)}")
    activate_variant()
    if "render" in asked:
        RENDERS.write_text(json.dumps(render(range(POINTS))) + "\n", encoding="utf-8")
    told: dict[str, Any] = json.loads(RESULT.read_text(encoding="utf-8")) if RESULT.exists() else {}
    if "fit" in asked:
        told = fitted()
    constants = Constants(**{name: each["value"] for name, each in told["constants"].items()})
    if "confirm" in asked:
        told |= confirm(constants)
        told["constants"]["exposure"]["value"] = told["exposure"]
        constants = replace(constants, exposure=told["exposure"])
    if "predict" in asked:
        covariance = np.array(told["covariance"])
        told["predictions"] = {
            "two thirds of the depth": predict(constants, covariance, 2 / 3),
            "layer thinner by a tenth": predict(constants, covariance, 1.0, THINNER),
        }
    RESULT.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    _plot(told)


def fitted() -> dict[str, Any]:
    """Both fits: with a camera whose grey levels are linear in light, and with a gamma of its own."""
    real = np.array([profile(observed("ref")), profile(observed("sample"))])
    rings = Rings(places(), np.array(json.loads(RENDERS.read_text(encoding="utf-8"))))
    first = fit(rings, real, gamma=1.0)[0]
    rings.correct(first, np.array([profile(each) for each in radiance(first, *CAREFUL)]))
    told: dict[str, Any] = {}
    for name, gamma in (("linear camera", 1.0), ("gamma free", None)):
        constants, sds, covariance, rms = fit(rings, real, gamma=gamma)
        print(name, rms, constants, flush=True)
        both = {key: {"value": value, "sd": sds[key]} for key, value in asdict(constants).items()}
        told[name] = {"rms_grey": rms, "constants": both, "covariance": covariance.tolist()}
    chosen = told["linear camera"]
    return {"constants": chosen["constants"], "covariance": chosen["covariance"], "fits": told}


def _plot(told: dict[str, Any]) -> None:
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
    curves = {name: np.array(curve) for name, curve in told["curves"].items()}
    for name, curve in curves.items():
        axis = axes[1] if name.startswith("untouched") else axes[0]
        mark = "o" if "observed" in name else "-"
        axis.plot(MIDDLES_MM, -curve if axis is axes[0] else curve, mark, ms=4, label=name)
    for name, each in told.get("predictions", {}).items():
        axes[0].plot(MIDDLES_MM, -np.array(each["curve"]), "--", lw=1, label=f"predicted, {name}")
    axes[0].set(xlabel="radius from the contact [mm]", ylabel="change by the press [grey levels]")
    axes[1].set(xlabel="radius from the contact [mm]", ylabel="untouched [grey levels]", ylim=(0, 200))
    for axis in axes:
        axis.legend(fontsize=8)
        axis.grid(alpha=0.3)
    figure.savefig(FOLDER.parent / "real-frames.png", dpi=110)


def _draw(pairs: dict[str, tuple[Array, Array]]) -> None:
    """Real frames above, simulated ones below, all on the grey levels 0 to 255."""
    figure, axes = plt.subplots(2, len(pairs), figsize=(8.4, 4.5), layout="constrained")
    for column, (name, pair) in zip(axes.T, pairs.items(), strict=True):
        column[0].set_title("change by the press, from 128" if name == "change" else name, fontsize=10)
        for axis, frame in zip(column, pair, strict=True):
            axis.imshow(frame, cmap="gray", vmin=0, vmax=255)
            axis.set(xticks=[], yticks=[])
    for axis, label in zip(axes[:, 0], ("real", "simulated"), strict=True):
        axis.set_ylabel(label)
    figure.savefig(FOLDER.parent / "real-frames-pictures.png", dpi=90)


if __name__ == "__main__":
    main()
