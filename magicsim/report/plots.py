"""The plots of a report, each from frames and verdicts to SVG text."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from magicsim.judge.changed_frames import runs
from magicsim.judge.score import contact_right, proximity_right
from magicsim.judge.verdicts import Judgement
from magicsim.report.drawing import BLUE, CLASS_COLORS, FAINT, INK, LINE, ORANGE, WIDTH_IN, WRONG, plot_style, to_svg
from magicsim.report.text import number
from magicsim.simulation.episode import SimulatedFrame

Series = npt.NDArray[np.float64]
_PANEL_IN = 1.25
_FOOT_IN = 0.44
_HEAD_IN = 0.26
_GAP_IN = 0.34
_SIDES = (0.1, 0.985)


def frame_times(frames: Sequence[SimulatedFrame]) -> Series:
    """Times of the frames [s], shape (frames,)."""
    return np.array([frame.truth.time_s for frame in frames], dtype=np.float64)


def time_panels(frames: Sequence[SimulatedFrame], titles: Sequence[str]) -> tuple[Figure, list[Axes]]:
    """Empty panels one above the other, shaded by class."""
    count = len(titles)
    height = _HEAD_IN + count * _PANEL_IN + (count - 1) * _GAP_IN + _FOOT_IN
    figure = Figure(figsize=(WIDTH_IN, height))
    grid = figure.add_gridspec(
        count, 1, left=_SIDES[0], right=_SIDES[1], top=1.0 - _HEAD_IN / height, bottom=_FOOT_IN / height,
        hspace=_GAP_IN / _PANEL_IN,
    )  # fmt: skip
    panels = [figure.add_subplot(grid[row, 0]) for row in range(count)]
    times = frame_times(frames)
    half = 0.5 * float(np.diff(times).min()) if len(times) > 1 else 0.5
    for panel, title in zip(panels, titles, strict=True):
        panel.set_title(title, pad=4.0)
        panel.set_xlim(times[0] - half, times[-1] + half)
        panel.grid(visible=True, axis="y", color=FAINT, linewidth=0.6)
        panel.tick_params(length=0.0, labelbottom=panel is panels[-1])
        _shade_classes(panel, frames, times, half)
    panels[-1].set_xlabel("time [s]")
    return figure, panels


def _shade_classes(panel: Axes, frames: Sequence[SimulatedFrame], times: Series, half: float) -> None:
    for each, places in runs([frame.truth.frame_class for frame in frames]):
        if each is not None:
            ends = times[places[0]] - half, times[places[-1]] + half
            panel.axvspan(*ends, color=CLASS_COLORS[each], alpha=0.28, linewidth=0.0, zorder=0.0)


def plot_features(frames: Sequence[SimulatedFrame], judgement: Judgement, *, name: str) -> str:
    """E, C and S over time with their thresholds; wrong verdicts are crosses, proximity's on E and C."""
    pairs = [(one, frame.truth.frame_class) for one, frame in zip(judgement.verdicts, frames, strict=True)]
    far = np.array([proximity_right(*pair) is False for pair in pairs])
    touch = np.array([contact_right(*pair) is False for pair in pairs])
    rows = (
        ("E", "entropy [bit]", "entropy", "tau_e", far, (0.0, 1.0)),
        ("C", "correlation", "correlation", "tau_c", far, (0.0, 1.0)),
        ("S", "grid similarity", "similarity", "tau_g", touch, (judgement.thresholds["tau_g"], 1.0)),
    )
    times = frame_times(frames)
    with plot_style():
        titles = [
            f"{letter}: {words}, threshold {number(judgement.thresholds[tau])}" for letter, words, _, tau, _, _ in rows
        ]
        figure, panels = time_panels(frames, titles)
        for panel, (_, _, field, tau, wrong, ends) in zip(panels, rows, strict=True):
            values = np.array([getattr(one, field) for one in judgement.verdicts], dtype=np.float64)
            panel.axhline(judgement.thresholds[tau], color=INK, linewidth=1.0, dashes=(4, 3), gid=tau)
            panel.plot(times, values, color=LINE, gid=field)
            panel.plot(times[wrong], values[wrong], "x", color=WRONG, ms=6, mew=1.8, gid=f"wrong-{field}")
            _fit(panel, np.append(values, judgement.thresholds[tau]), ends)
        return to_svg(figure, name=name, label="Entropy, correlation and similarity over time")


def plot_forces(frames: Sequence[SimulatedFrame], *, name: str) -> str:
    """Force, depth and gap over time."""
    times, force = frame_times(frames), _forces(frames)
    sideways = np.hypot(force[:, 0], force[:, 1])
    depth = np.array([frame.truth.depth_mm for frame in frames], dtype=np.float64)
    gaps = np.array([frame.truth.state.gap_mm for frame in frames], dtype=np.float64)  # not a number without an object
    gap = np.maximum(gaps, 0.0)
    with plot_style():
        figure, panels = time_panels(frames, ["force [N]", "depth [mm]", "open gap [mm]"])
        panels[0].plot(times, force[:, 2], color=BLUE, label="along z", gid="force-z")
        panels[0].plot(times, sideways, color=ORANGE, label="sideways", dashes=(4, 1.5), gid="force-xy")
        panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderpad=0.0, borderaxespad=0.2)
        panels[1].plot(times, depth, color=LINE, gid="depth")
        panels[2].plot(times, gap, color=LINE, marker=".", ms=3, gid="gap")
        for panel, values in zip(panels, (np.append(force[:, 2], sideways), depth, gap), strict=True):
            _fit(panel, values, (0.0, 0.1))
        return to_svg(figure, name=name, label="Force, depth and open gap over time")


def plot_force_depth(frames: Sequence[SimulatedFrame], *, name: str) -> str:
    """Force along z against depth, loading and unloading apart.

    A frame belongs to the unloading where it is less deep than the frame before it, to the loading where it
    is deeper, and to the hold where the depth stays. Only frames with contact are drawn.
    """
    depth = np.array([frame.truth.depth_mm for frame in frames], dtype=np.float64)
    contact = np.array([frame.truth.contact for frame in frames], dtype=np.bool_)
    force = _forces(frames)[:, 2]
    step = np.diff(depth, prepend=0.0)
    looks = (
        ("loading", step > 0.0, BLUE, "o"),
        ("held or sheared", step == 0.0, ORANGE, "s"),
        ("unloading", step < 0.0, INK, "v"),
    )
    with plot_style():
        figure = Figure(figsize=(WIDTH_IN, 3.9))
        panel = figure.add_axes((0.11, 0.115, 0.875, 0.815))
        panel.grid(visible=True, color=FAINT, linewidth=0.6)
        panel.tick_params(length=0.0)
        panel.plot(depth[contact], force[contact], color=FAINT, linewidth=1.0, gid="path")
        for label, chosen, color, marker in looks:
            both = contact & chosen
            (marks,) = panel.plot(depth[both], force[both], linestyle="none", marker=marker, label=label)
            marks.set(color=color, markersize=5.0, fillstyle="none" if color == INK else "full", gid=label.split()[0])
        panel.legend(loc="upper left", handletextpad=0.3)
        panel.set_xlabel("depth [mm]")
        panel.set_title("force along z [N]", pad=4.0)
        return to_svg(figure, name=name, label="Force against depth")


def _forces(frames: Sequence[SimulatedFrame]) -> npt.NDArray[np.float64]:
    """Forces [N], shape (frames, 3)."""
    return np.array([frame.truth.force_n for frame in frames], dtype=np.float64).reshape(-1, 3)


def _fit(panel: Axes, values: Series, ends: tuple[float, float]) -> None:
    """Let a panel show all values and at least the range `ends`, with a margin."""
    finite = values[np.isfinite(values)]
    low, high = min(ends[0], *finite, ends[1]), max(*ends, *finite)
    margin = 0.06 * (high - low)
    panel.set_ylim(low - margin, high + margin)
