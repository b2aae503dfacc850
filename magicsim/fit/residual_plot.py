"""Draws observed and simulated frames, and what is left between them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from magicsim.fit.model import Comparison
from magicsim.fit.observation import Observation
from magicsim.folder import PRODUCER, result_file

CHANNELS = ("red", "green", "blue")
COLORS = ("#d55e00", "#009e73", "#0072b2")
"""Okabe and Ito (Color Universal Design, 2008)."""


def plot_residual(observations: Sequence[Observation], found: Comparison, target: Path) -> None:
    """A row for each state: observed, simulated, difference of block means by channel, and both profiles along x.

    Args:
        observations: In the order of the comparison.
        found: The fitted sensor.
        target: PNG file.
    """
    figure = Figure(figsize=(15, 3.4 * len(observations)), layout="constrained")
    panels = figure.subplots(len(observations), 6, squeeze=False)
    reach = max(1.0, float(np.abs(found.means).max()))
    for row, (seen, image, means) in zip(
        panels, zip(observations, found.images, found.means, strict=True), strict=True
    ):
        name = "untouched" if seen.frame is None else f"frame {seen.frame}"
        for panel, title, picture in ((row[0], "observed", seen.mean), (row[1], "simulated", image)):
            panel.imshow(np.rint(np.clip(picture, 0, 255)).astype(np.uint8))
            panel.set_title(f"{name}: {title}", fontsize=9)
            panel.set_axis_off()
        for channel, panel in enumerate(row[2:5]):
            shown = panel.imshow(means[..., channel], cmap="RdBu_r", vmin=-reach, vmax=reach)
            panel.set_title(f"{CHANNELS[channel]}: simulated - observed, blocks", fontsize=8)
            panel.set_axis_off()
        figure.colorbar(shown, ax=row[4], label="grey levels")
        for channel, color in enumerate(COLORS):
            row[5].plot(seen.mean[..., channel].mean(0), color=color, linewidth=0.8)
            row[5].plot(image[..., channel].mean(0), color=color, linewidth=0.8, linestyle="--")
        row[5].set_title("mean of the columns; dashed: simulated", fontsize=8)
        row[5].set_xlabel("column [px]", fontsize=8)
    with result_file(target) as partial:
        figure.savefig(partial, dpi=80, format="png", metadata={"Software": PRODUCER})
