"""The parts of a judgement: each takes a sensor and gives measures, curves and pictures.

Where a touch was, by a regressor that anyone would try first: ridge regression on where the image changes.

The features are six numbers a frame. With a dozen touches, whole small images as features do several times worse.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cache, partial
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Index
from magicsim.deform.indentation.press import press
from magicsim.errors import ConfigError, ConvergenceError, FrameError, MagicsimError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import resolve_grid
from magicsim.light.records.untouched import UntouchedStates
from magicsim.notebook.screen import beside_change
from magicsim.report.text import data_uri
from magicsim.sweep import detection, texture
from magicsim.sweep.designs import SweptSensor, renderings_of
from magicsim.sweep.detection import FittedDetector, mean_similarity
from magicsim.sweep.film import DesignFilm, film_design
from magicsim.sweep.measures import Measured, SweepQuality
from magicsim.sweep.mechanics import FORCE_DEPTH_MM, press_curve, spacing_error
from magicsim.sweep.result import Block, Curve
from magicsim.sweep.sweep_file import SweepConfig
from magicsim.sweep.texture import Pattern, PatternPowers, PlateFrames

TINY = 1e-12
PENALTIES = (1e-4, 1e-3, 1e-2, 1e-1)
"""Penalties of the ridge, in units of the mean square of the features; chosen without the place that is left out."""
DRAWS = 2
"""Frames of each touch."""
FIRST = 300
"""First noise stream."""


def change_centroids(frame: npt.ArrayLike, reference: Array) -> Array:
    """Centroid of the squared change from the mean untouched frame, column and row of each channel, shape (6,).

    In shares of the image's size from its centre; both images have shape (rows, columns, 3).
    """
    change = np.square(np.asarray(frame, float) - reference)
    total = np.maximum(change.sum((0, 1)), TINY)
    parts = []
    for axis in (1, 0):
        place = (np.arange(change.shape[axis]) + 0.5) / change.shape[axis] - 0.5
        parts.append(np.tensordot(place, change.sum(1 - axis), (0, 0)) / total)
    return np.concatenate(parts)


def localisation_error(predicted: Sequence[Array], places: Array, *, seed: int) -> Measured:
    """Root mean square error of the place of a touch, mean over renderings [mm].

    Places, predicted by each rendering and true, have shape (touches, 2) [mm].
    """

    def error(squared: Array, numbers: Index) -> float:
        return float(np.sqrt(squared[numbers].mean()))

    errors = [partial(error, ((each - places) ** 2).sum(1)) for each in predicted]
    return Measured.mean_over(errors, len(places), seed=seed)


def predicted_places(film: DesignFilm) -> Array:
    """Place of each touch as the regressor says that has seen the others, shape (touches, 2) [mm]."""
    reference = np.mean(film.references(), axis=0)
    seen = [film.frames(each, DRAWS, first=FIRST) for each in film.touches]
    features = np.stack([np.mean([change_centroids(each, reference) for each in frames], axis=0) for frames in seen])
    return left_out_predictions(features, true_places(film))


def true_places(film: DesignFilm) -> Array:
    """Place of each touch, shape (touches, 2) [mm]."""
    return np.array([[each.x_mm, each.y_mm] for each in film.touches])


def left_out_predictions(features: Array, targets: Array) -> Array:
    """Predictions of each row by a ridge regression on all other rows, shape (rows, targets)."""

    def error(penalty: float, features: Array, targets: Array) -> float:
        return float(np.square(_left_out(features, targets, lambda *_: penalty) - targets).sum())

    return _left_out(features, targets, lambda *rest: min(PENALTIES, key=lambda each: error(each, *rest)))


def _left_out(features: Array, targets: Array, penalty: Callable[[Array, Array], float]) -> Array:
    """Predictions of each row from all others with the penalty that these ask for, in the dual form of the ridge."""
    numbers, result = np.arange(len(features)), np.zeros_like(targets)
    for held in numbers:
        known, wanted = features[numbers != held], targets[numbers != held]
        mean, centre = known.mean(0), wanted.mean(0)
        rows = known - mean
        gram = rows @ rows.T
        ridge = penalty(known, wanted) * np.trace(gram) / len(rows) * np.eye(len(rows))
        weights = np.linalg.solve(gram + ridge, wanted - centre)
        result[held] = ((features[held : held + 1] - mean) @ rows.T @ weights + centre)[0]
    return result


Filmed = tuple[DesignFilm, FittedDetector]
"""A rendering of the film, and a detector of its own."""
SPACING_MEASURES: dict[Pattern, str] = {"dots": "dot_spacing_mm", "lines": "line_spacing_mm"}
SHOWN_GAPS = 3
"""Nearest states of the approach that have a picture."""


@dataclass(slots=True, kw_only=True)
class Parts:
    """Everything that has been measured out so far."""

    measures: dict[str, Measured] = field(default_factory=dict)
    curves: dict[str, Curve] = field(default_factory=dict)
    pictures: dict[str, str] = field(default_factory=dict)
    profile: dict[str, Any] = field(default_factory=dict)

    def add(self, more: Self) -> None:
        """Takes another part in."""
        for name in ("measures", "curves", "pictures", "profile"):
            getattr(self, name).update(getattr(more, name))


def block_of(design: ElastomerDesign) -> Block:
    """The block as it would be printed.

    Raises:
        GeometryError: The grid does not fit.
    """
    grid = resolve_grid(design)
    cell: Any = None if grid is None else tuple(float(each) for each in grid.cell_mm)
    return Block(
        footprint_mm=design.footprint_mm, height_mm=design.height_mm, skin_mm=design.skin_mm, wall_mm=design.wall_mm,
        counts=None if grid is None else grid.counts, cell_mm=cell,
    )  # fmt: skip


def filmed(sensor: SweptSensor, sweep: SweepConfig, untouched: UntouchedStates) -> Parts:
    """Everything that one film serves."""
    seen = [each.sensor for each in renderings_of(sensor, sweep)]
    films = film_design(seen, sweep.object, sweep.quality, seed=sweep.seed, untouched=untouched)
    first = films[0]
    parts = Parts(pictures=_pictures(first))
    wanted, by_similarity = set(sweep.measures), ("sensitivity_per_mm", "sensitivity_per_n")
    by_detector = ("proximity_range_mm", "contact_auc", "contact_accuracy")
    if wanted & {"force_1mm_n", "stiffness_n_per_mm"}:
        parts.add(_pressed(sensor, sweep, first))
    if wanted & {"frame_seconds", "unknowns"}:
        parts.add(_cost(sensor, sweep, first))
    draws, seed = sweep.quality.draws, sweep.seed
    if "localisation_mm" in wanted:
        places, predicted = true_places(first), [predicted_places(film) for film in films]
        parts.measures["localisation_mm"] = localisation_error(predicted, places, seed=seed)
        both = {"": places, "predicted_": predicted[0]}
        parts.curves["localisation"] = {
            f"{kind}{axis}_mm": each[:, number].tolist()
            for kind, each in both.items()
            for number, axis in enumerate("xy")
        }
    if wanted & set(by_similarity):
        try:
            parts.add(_touched([(film, detection.fixed_detector(film)) for film in films], draws, seed))
        except FrameError as error:  # no pixel is bright enough
            parts.measures |= {name: Measured(value=None, note=str(error)) for name in by_similarity}
    if wanted & set(by_detector):
        try:
            parts.add(_detected([(film, detection.fit_detector(film)) for film in films], sweep.quality, seed))
        except ConfigError as error:  # no option of the detector sees a grid
            parts.measures |= {name: Measured(value=None, note=str(error)) for name in by_detector}
    return parts


def textured(sensor: SweptSensor, sweep: SweepConfig, untouched: UntouchedStates) -> Parts:
    """The smallest spacing of each wanted pattern, each spacing compared with a plain plate of the same size."""

    def pressed(pattern: Pattern | None, spacing_mm: float) -> PlateFrames:
        return texture.press_plate(
            sensor, pattern, spacing_mm, sweep.quality, like=sweep.object, seed=sweep.seed, untouched=untouched
        )

    plain = cache(partial(pressed, None))
    parts = Parts()
    for pattern, measure in SPACING_MEASURES.items():
        if measure in sweep.measures:
            parts.add(_pattern(sweep, pattern, partial(pressed, pattern), plain))
    return parts


def _pattern(
    sweep: SweepConfig, pattern: Pattern, pressed: Callable[[float], PlateFrames], plain: Callable[[float], PlateFrames]
) -> Parts:
    """One pattern; a spacing that cannot be pressed counts as missed."""
    quality, name = sweep.quality, SPACING_MEASURES[pattern]
    observed: dict[float, PatternPowers] = {}
    pictures, notes = {}, []
    # From the finest on until one is told apart. Coarser ones say nothing of the smallest: a pattern near the pitch of
    # the printed grid may be masked by it, and both finer and coarser ones may not.
    for spacing in reversed(quality.dot_spacings_mm if pattern == "dots" else quality.line_spacings_mm):
        try:
            shown = pressed(spacing)
            observed[spacing] = texture.observe(shown, plain(spacing), pattern, spacing)
        except MagicsimError as error:
            notes.append(f"at {spacing:g} mm: {error}")
            continue
        pictures[f"{pattern} every {spacing:g} mm"] = data_uri(shown.picture)
        if observed[spacing].d_prime() >= texture.TOLD_APART:
            break
    if not observed:
        return Parts(measures={name: Measured(value=None, note="; ".join(notes))})
    spacings = sorted(observed, reverse=True)
    measured = texture.smallest_spacing(np.array(spacings), [observed[each] for each in spacings], seed=sweep.seed)
    measured = replace(measured, note="; ".join(text for text in (measured.note, *notes) if text))
    curve: Curve = {"spacing_mm": list(spacings), "d_prime": [observed[each].d_prime() for each in spacings]}
    return Parts(measures={name: measured}, curves={f"{pattern}_d_prime": curve}, pictures=pictures)


def _pressed(sensor: SweptSensor, sweep: SweepConfig, film: DesignFilm) -> Parts:
    depths = np.array(sweep.quality.depths_mm)
    force = np.array([each.force_n for each in film.press])
    try:
        last = float(force[depths == FORCE_DEPTH_MM][0])
        error = spacing_error(sensor.design, sweep.object, last, cells_across=sweep.quality.cells_across)
    except ConvergenceError:
        error = float("nan")
    measured = press_curve(depths, force, relative_error=error)
    return Parts(
        measures={"force_1mm_n": measured[0], "stiffness_n_per_mm": measured[1]},
        curves={"force": {"depth_mm": [0.0, *depths.tolist()], "force_n": [0.0, *force.tolist()]}},
    )


def _cost(sensor: SweptSensor, sweep: SweepConfig, film: DesignFilm) -> Parts:
    """Cost of a touch on the design's own lattice, as `magicsim press` solves it, and of its rendering."""
    try:
        own = press(sensor.design, sweep.object, depth_mm=sweep.quality.touch_depth_mm)
    except MagicsimError as error:
        return Parts(measures=dict.fromkeys(("frame_seconds", "unknowns"), Measured(value=None, note=str(error))))
    seconds = own.seconds + np.array([each.seconds for each in (*film.press, *film.touches)])
    low, middle, high = np.quantile(seconds, [0.25, 0.5, 0.75]).tolist()
    unknowns = Measured(value=float(own.unknowns), low=float(own.unknowns), high=float(own.unknowns))
    return Parts(measures={"frame_seconds": Measured(value=middle, low=low, high=high), "unknowns": unknowns})


def _touched(films: Sequence[Filmed], draws: int, seed: int) -> Parts:
    light = np.array([mean_similarity(film.light_touches, film, detector, draws) for film, detector in films])
    firm = np.array([mean_similarity(film.touches, film, detector, draws) for film, detector in films])
    film, detector = films[0]
    first, last = film.light_touches[0], film.touches[0]
    deeper, harder = (first.gap_mm or 0.0) - (last.gap_mm or 0.0), last.force_n - first.force_n
    similarity = mean_similarity(film.press, film, detector, draws).tolist()
    return Parts(
        measures={
            "sensitivity_per_mm": detection.contact_sensitivity(light, firm, step=deeper, seed=seed),
            "sensitivity_per_n": detection.contact_sensitivity(light, firm, step=harder, seed=seed),
        },
        curves={"similarity": {"depth_mm": [-(each.gap_mm or 0.0) for each in film.press], "similarity": similarity}},
    )


def _detected(films: Sequence[Filmed], quality: SweepQuality, seed: int) -> Parts:
    approaches = [detection.approach_curve(film, detector, quality.draws) for film, detector in films]
    scores = [detection.contact_scores(film, detector, quality.draws, drift=quality.drift) for film, detector in films]
    columns = {
        "entropy": [each.entropy.mean(1) for each in approaches],
        "correlation": [each.correlation.mean(1) for each in approaches],
        "rate": [each.rates() for each in approaches],
    }
    means = {name: np.mean(values, axis=0).tolist() for name, values in columns.items()}
    return Parts(
        measures={
            "proximity_range_mm": detection.proximity_range(approaches, seed=seed),
            "contact_auc": detection.contact_auc(scores, seed=seed),
            "contact_accuracy": detection.contact_accuracy(scores, seed=seed),
        },
        curves={"approach": {"gap_mm": approaches[0].gaps_mm.tolist(), **means}} | _contact(films, quality, seed),
        profile={
            name: value for name, value in asdict(films[0][1].profile).items()
            if name.startswith("tau_") or name in {"polarity", "similarity", "grid_blur_px", "difference_blur_px"}
        },
    )  # fmt: skip


def _contact(films: Sequence[Filmed], quality: SweepQuality, seed: int) -> dict[str, Curve]:
    """How well contact is told at each further depth; nothing where none is asked for."""
    found: Curve = {"depth_mm": list(quality.contact_depths_mm)}
    for number in range(len(quality.contact_depths_mm)):
        scores = [
            detection.contact_scores(film, detector, quality.draws, drift=quality.drift, touches=film.others[number])
            for film, detector in films
        ]
        for name, measure in (("auc", detection.contact_auc), ("accuracy", detection.contact_accuracy)):
            each = measure(scores, seed=seed)
            for end, value in ((name, each.value), (f"{name}_low", each.low), (f"{name}_high", each.high)):
                found.setdefault(end, []).append(value)
    return {"contact": found} if quality.contact_depths_mm else {}


def _pictures(film: DesignFilm) -> dict[str, str]:
    shown = {"untouched": film.untouched}
    shown |= {f"gap {each.gap_mm:g} mm": each for each in film.approach[-SHOWN_GAPS:]}
    shown |= {f"depth {-(each.gap_mm or 0):g} mm": each for each in film.press}
    rest, gamma = np.mean(film.references(), axis=0), film.camera.gamma
    frames = {caption: film.frames(each, 1)[0] for caption, each in shown.items()}
    return {caption: data_uri(beside_change(frame, rest, gamma=gamma)) for caption, frame in frames.items()}
