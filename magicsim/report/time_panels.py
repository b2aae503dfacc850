"""Panels above one time axis, with the true classes as shades behind them."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from magicsim.report.drawing import WIDTH_IN
from magicsim.report.palette import CLASS_COLORS, FAINT
from magicsim.report.runs import runs
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
    """Empty panels one above the other, shaded by class.

    Args:
        frames: The scored frames, at least one.
        titles: One for each panel, from the top.
    """
    count = len(titles)
    height = _HEAD_IN + count * _PANEL_IN + (count - 1) * _GAP_IN + _FOOT_IN
    figure = Figure(figsize=(WIDTH_IN, height))
    grid = figure.add_gridspec(
        count,
        1,
        left=_SIDES[0],
        right=_SIDES[1],
        top=1.0 - _HEAD_IN / height,
        bottom=_FOOT_IN / height,
        hspace=_GAP_IN / _PANEL_IN,
    )
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
    for run in runs([frame.truth.frame_class for frame in frames]):
        if run.value is not None:
            panel.axvspan(
                times[run.start] - half,
                times[run.stop - 1] + half,
                color=CLASS_COLORS[run.value],
                alpha=0.28,
                linewidth=0.0,
                zorder=0.0,
            )
