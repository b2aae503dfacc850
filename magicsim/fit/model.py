"""What a simulated sensor with some constants looks like in the observed states, and how far that is off."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from magicsim.arrays import Array
from magicsim.camera.camera import Camera
from magicsim.conventions import CHANNELS
from magicsim.deform.deformation import Deformation
from magicsim.errors import ConfigError
from magicsim.fit.constants import with_values
from magicsim.fit.observation import Observation
from magicsim.fit.strengths import Basis, Strengths, block_contrast, block_means, fit_strengths, lit_signal
from magicsim.folder import PRODUCER, result_file
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState, timeline
from magicsim.simulation.sensor import Sensor

_OPTICAL_FIELDS = {"ior", "sigma_s_per_mm", "absorption_per_mm", "anisotropy"}


@dataclass(slots=True)
class Equilibria:
    """What has been solved, by design and state; the object and its friction must stay the same."""

    _solved: dict[tuple[str, FrameState], Deformation] = field(default_factory=dict)

    def of(self, sensor: Sensor, state: FrameState) -> Deformation:
        """Equilibrium of a sensor in a state, from rest."""
        if not state.can_touch:
            return sensor.rest
        optics = {"materials": {"body": _OPTICAL_FIELDS, "infill": _OPTICAL_FIELDS}}
        key = (sensor.design.model_dump_json(exclude=optics), state)
        if key not in self._solved:
            self._solved[key] = sensor.deform(state, sensor.rest)
        return self._solved[key]


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A simulated sensor beside the observations."""

    strengths: Strengths
    images: list[Array]
    """Predicted grey levels of each state, shape (rows, columns, 3)."""
    means: Array
    """Predicted less observed block means [grey levels], shape (states, blocks down, blocks across, 3)."""
    contrasts: Array
    """Predicted less observed spread inside the blocks [grey levels], of that shape."""

    @property
    def residuals(self) -> Array:
        """All of them in one row [grey levels]."""
        return np.concatenate([self.means.ravel(), self.contrasts.ravel()])


def observed_states(scene: SceneConfig, observations: Sequence[Observation]) -> list[FrameState]:
    """States that the observations show; `ConfigError` where the scene has no such frame."""
    states = timeline(scene)
    for each in observations:
        if each.frame is not None and not 0 <= each.frame < len(states):
            msg = f"frame = {each.frame} is not allowed: must be 0 to {len(states) - 1}, a scored frame of the scene"
            raise ConfigError(msg)
    return [UNTOUCHED if each.frame is None else states[each.frame] for each in observations]


def render_bases(
    scene: SceneConfig,
    values: Mapping[str, object],
    states: Sequence[FrameState],
    equilibria: Equilibria,
    *,
    pair: int = 0,
) -> list[tuple[Basis, Basis]]:
    """Two independent sets of basis images for each state.

    All constants share the random numbers, so that a difference between two of them is one of light and not of noise.
    """
    sensor = Sensor.for_scene(with_values(scene, values))
    views = [sensor.view(state, equilibria.of(sensor, state)) for state in states]
    first, second = 2 * pair, 2 * pair + 1
    return [(sensor.renderer.basis(view, turn=first), sensor.renderer.basis(view, turn=second)) for view in views]


def compare(
    bases: Sequence[tuple[Basis, Basis]],
    observations: Sequence[Observation],
    camera: Camera,
    *,
    blocks: tuple[int, int],
) -> Comparison:
    """Sets basis images beside observations, with the strengths of the lights that suit best."""
    matrix = np.array(camera.color_matrix)
    both = [
        {name: np.asarray((image + other[name]) / 2, np.float32) for name, image in one.items()} for one, other in bases
    ]
    signals = [(each.mean / 255) ** camera.gamma for each in observations]
    strengths = fit_strengths(both, signals, matrix, blocks=blocks, gamma=camera.gamma)
    images = [(_grey(strengths, one, camera), _grey(strengths, other, camera)) for one, other in bases]
    means, contrasts = [], []
    for (one, other), seen in zip(images, observations, strict=True):
        means.append(block_means((one + other) / 2, blocks) - block_means(seen.mean, blocks))
        contrasts.append(block_contrast(one, other, blocks) - block_contrast(seen.even, seen.odd, blocks))
    return Comparison(
        strengths=strengths,
        images=[(one + other) / 2 for one, other in images],
        means=np.array(means),
        contrasts=np.array(contrasts),
    )


COLORS = ("#d55e00", "#009e73", "#0072b2")
"""Okabe and Ito (Color Universal Design, 2008)."""


def _grey(strengths: Strengths, basis: Basis, camera: Camera) -> Array:
    signal = lit_signal(strengths, basis, np.array(camera.color_matrix))
    return np.asarray(255 * np.clip(signal, 0, 1) ** (1 / camera.gamma))


def whole_untouched(scene: SceneConfig, values: Mapping[str, object], strengths: Strengths) -> Array:
    """Grey levels of the whole untouched image, which exposure is metered on, shape (rows, columns, 3)."""
    whole = with_values(scene, {**values, "rig.camera.region_px": None})
    ((one, other),) = render_bases(whole, {}, [UNTOUCHED], Equilibria())
    return np.asarray((_grey(strengths, one, whole.rig.camera) + _grey(strengths, other, whole.rig.camera)) / 2)


def plot_residual(observations: Sequence[Observation], found: Comparison, target: Path) -> None:
    """A row for each state: observed, simulated, difference of block means by channel, and both profiles along x."""
    from matplotlib.figure import Figure

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
