"""Plots and pictures of an evaluation: detection rates and trade-offs as SVG text, and frames that tell most."""

from collections.abc import Mapping, Sequence
from itertools import islice

import numpy as np

from magicsim.evaluation.footage import Footage
from magicsim.frame_class import FrameClass
from magicsim.judge.changed_frames import FrameRun
from magicsim.judge.curves import CurvePoint, Roc
from magicsim.judge.tally import JudgedEpisode
from magicsim.notebook.screen import beside_change
from magicsim.report.drawing import BLUE, CLASS_COLORS, FAINT, LINE, ORANGE, drawn_panel, plot_style, to_svg
from magicsim.report.text import data_uri, gap_or_depth

_HEIGHT_IN = 3.2
_PLACE = (0.12, 0.15, 0.86, 0.76)


def plot_detection(
    points: Sequence[CurvePoint], *, axis: str, name: str, scored_mm: tuple[float, float], label: str
) -> str:
    """Detection rate by bins of distance or depth, with intervals; what counts in the scores is shaded [mm].

    There is at least one bin; `label` says what the drawing shows for a reader who cannot see it.
    """
    middles = np.array([(each.above_mm + each.to_mm) / 2 for each in points])
    halves = np.array([(each.to_mm - each.above_mm) / 2 for each in points])
    rates = np.array([each.rate for each in points])
    ends = [
        (each.rate if each.low is None else each.low, each.rate if each.high is None else each.high) for each in points
    ]
    lows, highs = np.array(ends).T
    errors = np.clip(np.stack([rates - lows, highs - rates]), 0, None)
    with plot_style():
        figure, panel = drawn_panel(_HEIGHT_IN, _PLACE)
        panel.axvspan(*scored_mm, color=FAINT, alpha=0.45, linewidth=0, gid="scored")
        panel.errorbar(
            middles, rates, yerr=errors, xerr=halves, linestyle="none", marker="o", ms=4, color=LINE, elinewidth=1.1,
        )  # fmt: skip
        panel.set_ylim(-0.03, 1.03)
        panel.set_xlim(min(0.0, middles[0] - halves[0]), max(middles[-1] + halves[-1], scored_mm[1]))
        panel.set_xlabel(axis)
        panel.set_title("detection rate", pad=4.0)
        return to_svg(figure, name=name, label=label)


def plot_roc(curves: Mapping[str, Roc | None], *, name: str) -> str:
    """ROC curves of approach and touch."""
    with plot_style():
        figure, panel = drawn_panel(_HEIGHT_IN, _PLACE)
        panel.plot([0, 1], [0, 1], color=FAINT, linewidth=0.8)
        for (title, roc), color, style in zip(curves.items(), (BLUE, ORANGE), ("-", "--"), strict=False):
            if roc is not None:
                panel.plot(roc.false_alarms, roc.detections, color=color, linestyle=style, label=title, gid=title)
        panel.set_xlim(-0.02, 1.0)
        panel.set_ylim(0.0, 1.03)
        panel.set_xlabel("share of false alarms")
        panel.set_title("share detected", pad=4.0)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(loc="lower right")
        return to_svg(figure, name=name, label="Trade-off between detections and false alarms")


MOST_CHANGED = 12
"""Pictures of changed frames, at most."""


CaptionedFrame = Mapping[str, str]
"""One frame beside its change (`uri`): `title`, `place`, `truth` and its `color`, and what is `said` of it."""


def sheet(footage: Sequence[Footage], episodes: Sequence[JudgedEpisode], standard: str) -> list[CaptionedFrame]:
    """A near and a pressed frame of every take in the standard condition, and a lit one of every other light."""
    noise = standard.split("/")[1]
    pictures = []
    for film, episode in zip(footage, episodes, strict=True):
        if film.tag.noise == noise:
            places = [*_nearest(episode, FrameClass.NEAR, 1.0), *_nearest(episode, FrameClass.CONTACT, -9.0)]
            pictures += _pictures(film, episode, places)
    return pictures


def changed_sheet(
    footage: Sequence[Footage], episodes: Sequence[JudgedEpisode], runs: Sequence[FrameRun]
) -> list[CaptionedFrame]:
    """The first frame of every run that changed, up to a dozen."""
    wanted: dict[str, list[int]] = {}
    for run in list(runs)[:MOST_CHANGED]:
        wanted.setdefault(run.episode, []).append(run.first)
    pictures = []
    for film, episode in zip(footage, episodes, strict=True):
        pictures += _pictures(film, episode, sorted(set(wanted.get(film.tag.name, ()))))
    return pictures


def _pictures(film: Footage, episode: JudgedEpisode, places: Sequence[int]) -> list[CaptionedFrame]:
    if not places:
        return []
    images = dict(enumerate(islice(film.images.frames(), max(places) + 1)))
    rest = np.mean(list(film.images.references()), axis=0)
    shown = {place: beside_change(images[place], rest, gamma=film.gamma) for place in places}
    return [{"uri": data_uri(shown[place])} | _caption(film, episode, place) for place in places]


def _caption(film: Footage, episode: JudgedEpisode, place: int) -> dict[str, str]:
    truth, gap = episode.labels.classes[place], float(episode.labels.gap_mm[place])
    light = ", flashlight" if episode.labels.flashlight[place] else ""
    return {
        "title": f"{film.tag.name} {place}",
        "place": gap_or_depth(None if np.isnan(gap) else gap) + light,
        "truth": str(truth) if truth is not None else "not scored",
        "color": CLASS_COLORS[truth] if truth is not None else "transparent",
        "said": f"{episode.proximity[place]}, {episode.contact[place]}",
    }


def _nearest(episode: JudgedEpisode, truth: FrameClass, gap_mm: float) -> list[int]:
    """The frame of a class whose gap is nearest to one, if there is any."""
    held = [place for place, one in enumerate(episode.labels.classes) if one is truth]
    return sorted(held, key=lambda place: abs(float(episode.labels.gap_mm[place]) - gap_mm))[:1]
