"""Fits assumed constants to images of a real sensor, and says which of them the images determine.

Gauss-Newton with a trust region and bounds (scipy's `trf`: Branch, Coleman and Li 1999) over the unit cube. Derivatives
are differences over a fixed share of each range: large against what is left of the rendering's noise, small against the
range.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from magicsim.arrays import Array
from magicsim.config.ranges import check_number
from magicsim.errors import ConfigError, OutputError
from magicsim.fit.constants import Constant, constants_named, fitted_scene, value_of, with_values, write_scene
from magicsim.fit.model import (
    Comparison,
    Equilibria,
    compare,
    observed_states,
    plot_residual,
    render_bases,
    whole_untouched,
)
from magicsim.fit.observation import Observation
from magicsim.fit.strengths import Basis, Strengths, check_blocks
from magicsim.folder import check_file, refuse_unsigned
from magicsim.scenes.scene import SceneConfig
from magicsim.waiting import Told, on_stderr, waiting

Residuals = Callable[[Array], Array]
STEP = 0.06
"""Share of a range over which a derivative is taken."""
UNKNOWN_SD = 12**-0.5
"""Standard deviation of what is known of nothing: even over its range."""
DETERMINED_SD = 0.1
"""Below this share of its range an unknown counts as determined."""
TOLERANCE = 2e-3
"""The search ends where a step changes neither point nor sum of squares by more than this share."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """The best point that was found, and how well the data hold it there."""

    point: Array
    rms: float
    """Root mean square residual there, in the residuals' unit."""
    sd: Array
    """Standard deviation of each unknown in shares of its range, at most `UNKNOWN_SD`."""
    jacobian: Array
    """Shape (residuals, unknowns) [residuals' unit for the whole range]."""
    singular_values: Array
    """Singular values of the Jacobian, largest first [residuals' unit for the whole range]."""
    weakest: Array
    """Unit vector along which the residuals change least, shape (unknowns,)."""
    ends: Array
    """Where each start ended, shape (starts, unknowns)."""
    ends_rms: list[float]
    evaluations: int


def solve(residuals: Residuals, start: Array, *, starts: int, evaluations: int, seed: int) -> Solution:
    """Finds the least squares from several starts."""
    known: dict[bytes, Array] = {}

    def evaluate(point: Array) -> Array:
        key = np.round(point, 12).tobytes()
        if key not in known:
            known[key] = residuals(point)
        return known[key]

    def jacobian(point: Array) -> Array:
        return differences(evaluate, point)

    sampler = qmc.Sobol(len(start), rng=np.random.default_rng(seed))
    points = [np.clip(start, 1e-3, 1 - 1e-3), *(sampler.random(1)[0] for _ in range(starts - 1))]
    found = [
        least_squares(
            evaluate, point, jac=jacobian, bounds=(0, 1), max_nfev=evaluations, xtol=TOLERANCE, ftol=TOLERANCE
        )
        for point in points
    ]
    best = min(found, key=lambda each: float(each.cost))
    slopes = jacobian(best.x)
    _, singular, directions = np.linalg.svd(slopes, full_matrices=False)
    return Solution(
        point=best.x, rms=_overall_rms(best.fun), sd=deviations(slopes, best.fun), jacobian=slopes,
        singular_values=singular, weakest=directions[-1], ends=np.array([each.x for each in found]),
        ends_rms=[_overall_rms(each.fun) for each in found], evaluations=len(known),
    )  # fmt: skip


def differences(residuals: Residuals, point: Array) -> Array:
    """Jacobian by differences of `STEP`, one-sided at the faces of the cube, shape (residuals, unknowns)."""
    columns = []
    for place in range(len(point)):
        low, high = point.copy(), point.copy()
        low[place], high[place] = max(point[place] - STEP, 0), min(point[place] + STEP, 1)
        columns.append((residuals(high) - residuals(low)) / (high[place] - low[place]))
    return np.stack(columns, axis=1)


def deviations(jacobian: Array, residuals: Array) -> Array:
    """Standard deviation of each unknown, with an even prior over its range.

    Gaussian: the inverse of J' J / s^2 + 12, where s^2 is the residuals' variance with as many degrees of freedom as
    there are more residuals than unknowns, and 12 the inverse variance of an even distribution over 0..1. Residuals of
    neighbouring blocks are alike where the model itself is off, so that it is the least that can be said.
    """
    free = max(1, len(residuals) - jacobian.shape[1])
    variance = max(float(residuals @ residuals) / free, np.finfo(float).tiny)
    covariance = np.linalg.inv(jacobian.T @ jacobian / variance + np.eye(jacobian.shape[1]) / UNKNOWN_SD**2)
    return np.asarray(np.sqrt(np.diag(covariance)))


def scatter(jacobian: Array, residuals: Sequence[Array]) -> Array:
    """How far each unknown would move with other noise of the model: shape (unknowns,), in shares of the ranges.

    Standard deviation of the Gauss-Newton steps that two or more independent residuals of one point ask for, with an
    even prior; the Jacobian at that point has shape (residuals, unknowns).
    """
    variance = max(float(np.mean([each @ each for each in residuals])) / jacobian.shape[0], np.finfo(float).tiny)
    normal = jacobian.T @ jacobian + variance * np.eye(jacobian.shape[1]) / UNKNOWN_SD**2
    steps = [np.linalg.solve(normal, jacobian.T @ each) for each in residuals]
    return np.asarray(np.std(steps, axis=0, ddof=1))


def _overall_rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


DEFAULT_FREE = ("body_ior", "infill_ior", "infill_scattering", "body_absorption", "strip_margin")
"""Constants that are fitted where nothing is said."""
CAMERA_ALONE = ("gamma",)
"""Constants that change no basis image."""
NOT_FITTED = ("exposure", "full_well", "read_noise")
"""Constants that mean frames do not hold: exposure comes with the strengths of the lights, noise is averaged away."""
MOST_STARTS, MOST_EVALUATIONS = 1000, 100_000
PAIRS = 4
"""Independent renderings of the fitted sensor by which the noise of the rendering is told."""
EDGE = 0.01
"""A fitted constant so near to an end of its range, as a share of it, would go on beyond."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedConstant:
    """One constant."""

    name: str
    field: str
    value: float
    low: float
    high: float
    """Ends of its assumed range."""
    plausible: tuple[float, float]
    """One standard deviation to either side."""
    sd_share: float
    """That deviation as a share of the range; 0.29 where the images say nothing. From the residuals and from the noise
    of the rendering; what is wrong with the model itself is in neither."""
    render_share: float
    """The part of it that comes from the noise of the rendering; more particles and samples lower it."""
    determined: bool
    """Whether it is below a tenth and the value lies inside the range."""
    restarts: list[float]
    """Where each start ended, the best one included."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FitResult:
    """What `magicsim fit` reports."""

    out: str
    """Scene file of the fitted sensor."""
    picture: str
    """Observed and simulated frames, and the residual."""
    constants: list[FittedConstant]
    strengths: dict[str, list[float]]
    """Strengths of each light in units of the rig's, red, green and blue, up to one common factor (the exposure)."""
    mean_rms: list[float]
    """Root mean square of what is left of the block means, of red, green and blue [grey levels]."""
    contrast_rms: list[float]
    """Root mean square of what is left of the contrast inside the blocks [grey levels]."""
    start_rms: float
    """Root mean square of all residuals of the scene's own constants [grey levels]."""
    rms: float
    """Root mean square of all residuals of the fitted constants [grey levels]."""
    restart_rms: list[float]
    singular_values: list[float]
    """Singular values of the residuals' derivatives, largest first: what the whole range of a combination of constants
    changes, as the length of the vector of residuals [grey levels]."""
    weakest: dict[str, float]
    """The combination that the images say least of, in shares of the ranges."""
    evaluations: int
    seconds: float


def fit_constants(
    scene: SceneConfig, observations: Sequence[Observation], out: Path, *, free: Sequence[str] = DEFAULT_FREE,
    blocks: tuple[int, int] = (8, 6), starts: int = 2, evaluations: int = 12, seed: int = 0,
    told: Told = on_stderr,
) -> FitResult:  # fmt: skip
    """Fits constants and writes the fitted scene and a picture of the residual.

    Args:
        scene: The sensor as it is assumed; everything that is not fitted stays. Its render settings say how well.
        observations: Of the untouched sensor first, then of scored frames of the scene.
        out: TOML file; the picture stands beside it, as `.png`.
        free: Names of the constants, keys of `magicsim.fit.constants.CONSTANTS`.
        blocks: Down and across.
        starts: Starts of the search, the scene's own constants first.
        evaluations: Points tried from each start at most, beside those of derivatives.
        seed: Of the other starts.
        told: Hears what takes longer than two seconds.

    Raises:
        MagicsimError: A constant, a scene, an image or the file cannot be used; then nothing is written.
    """
    constants = _checked(free, out, starts=starts, evaluations=evaluations)
    window = scene.rig.camera.window
    check_blocks(blocks, rows=window.rows, columns=window.columns)
    if not observations or observations[0].frame is not None:
        raise ConfigError("observations of the untouched sensor are missing; they must come first")
    if not any(scene.lit):
        msg = "no light of rig.strips, rig.leds and rig.ring shines, and the room is dark: there is nothing to fit"
        raise ConfigError(msg)
    observed_states(scene, observations)
    start_time, equilibria = time.perf_counter(), Equilibria()
    rendered: dict[tuple[float, ...], list[tuple[Basis, Basis]]] = {}
    optical = [place for place, name in enumerate(constants) if name not in CAMERA_ALONE]

    def values_at(point: Array) -> dict[str, object]:
        return {each.path: each.at(float(share)) for each, share in zip(constants.values(), point, strict=True)}

    def comparison(point: Array) -> Comparison:
        values, key = values_at(point), tuple(point[optical].tolist())
        if key not in rendered:
            rendered.clear()
            states = observed_states(with_values(scene, values), observations)
            rendered[key] = render_bases(scene, values, states, equilibria)
        return compare(rendered[key], observations, with_values(scene, values).rig.camera, blocks=blocks)

    with waiting("fitting constants", told):
        first = np.array([each.share(value_of(scene, each.path)) for each in constants.values()])
        start_rms = _overall_rms(comparison(first).residuals)
        solution = solve(
            lambda point: comparison(point).residuals, first, starts=starts, evaluations=evaluations, seed=seed
        )
        best = comparison(solution.point)
        values = values_at(solution.point)
        camera = with_values(scene, values).rig.camera
        states = observed_states(with_values(scene, values), observations)
        again = [
            compare(render_bases(scene, values, states, equilibria, pair=pair), observations, camera, blocks=blocks)
            for pair in range(1, PAIRS)
        ]
        rendering = scatter(solution.jacobian, [best.residuals, *(each.residuals for each in again)])
        fits, picture = _fitted(constants, solution, rendering), out.with_suffix(".png")
        plot_residual(observations, best, picture)
        untouched = best.images[0] if camera.region_px is None else whole_untouched(scene, values, best.strengths)
        fitted = fitted_scene(scene, values, best.strengths, untouched)
        write_scene(out, fitted, comment=_comment(fits, solution, observations))
        return FitResult(
            out=str(out), picture=str(picture), constants=fits, strengths=_by_light(best.strengths),
            mean_rms=_rms(best.means), contrast_rms=_rms(best.contrasts), start_rms=start_rms, rms=solution.rms,
            restart_rms=solution.ends_rms, singular_values=solution.singular_values.tolist(),
            weakest=dict(zip(constants, solution.weakest.tolist(), strict=True)), evaluations=solution.evaluations,
            seconds=time.perf_counter() - start_time,
        )  # fmt: skip


def _checked(free: Sequence[str], out: Path, *, starts: int, evaluations: int) -> dict[str, Constant]:
    constants = constants_named(free)
    for name in NOT_FITTED:
        if name in constants:
            raise ConfigError(f"constant '{name}' cannot be fitted to mean frames")
    if not constants:
        raise ConfigError("no constant is free; name at least one")
    if out.suffix != ".toml":
        raise ConfigError(f"out = {out} is not allowed; must end in .toml")
    check_file(out)
    if not out.parent.is_dir():
        raise OutputError(f"scene file '{out}' cannot be written: no such folder")
    refuse_unsigned(out.with_suffix(".png"))  # the picture of the residual
    check_number("starts", starts, 1, MOST_STARTS, whole=True)
    check_number("evaluations", evaluations, 1, MOST_EVALUATIONS, whole=True)
    return constants


def _fitted(constants: Mapping[str, Constant], solution: Solution, rendering: Array) -> list[FittedConstant]:
    fits = []
    for place, (name, each) in enumerate(constants.items()):
        share = float(solution.point[place])
        sd = min(float(np.hypot(solution.sd[place], rendering[place])), UNKNOWN_SD)
        fits.append(
            FittedConstant(
                name=name, field=each.path, value=each.at(share), low=each.low, high=each.high,
                plausible=(each.at(max(share - sd, 0.0)), each.at(min(share + sd, 1.0))), sd_share=sd,
                render_share=float(rendering[place]),
                determined=sd < DETERMINED_SD and EDGE < share < 1 - EDGE,
                restarts=[each.at(float(end[place])) for end in solution.ends],
            )
        )  # fmt: skip
    return fits


def _comment(fits: Sequence[FittedConstant], solution: Solution, observations: Sequence[Observation]) -> str:
    frames, states = sum(each.count for each in observations), len(observations)
    lines = [
        f"Written by magicsim fit optics from {frames} frames of {states} states; residual {solution.rms:.2f} grey."
    ]
    for each in fits:
        said = "" if each.determined else ", not determined"
        lines.append(f"{each.field} = {each.value:.5g}, {each.plausible[0]:.5g} to {each.plausible[1]:.5g}{said}")
    return "\n".join(lines)


def _by_light(strengths: Strengths) -> dict[str, list[float]]:
    lights: dict[str, list[float]] = {}
    for (name, channel), value in strengths.items():
        lights.setdefault(name, [0.0, 0.0, 0.0])[channel] = value
    return lights


def _rms(values: Array) -> list[float]:
    return [float(each) for each in np.sqrt(np.mean(values**2, axis=(0, 1, 2)))]
