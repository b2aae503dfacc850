"""The plot of curves and the real frames above the simulated ones."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from laboratory.real_frames.frames import FOLDER, MIDDLES_MM
from magicsim.arrays import Array


def plot(told: dict[str, Any]) -> None:
    """Curves of the change by the press and of the untouched frame, observed, fitted and predicted."""
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


def draw_pairs(pairs: dict[str, tuple[Array, Array]]) -> None:
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
