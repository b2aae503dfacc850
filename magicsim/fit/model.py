"""What a simulated sensor with some constants looks like in the observed states, and how far that is off."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array
from magicsim.camera.camera import Camera
from magicsim.errors import ConfigError
from magicsim.fit.blocks import block_contrast, block_means
from magicsim.fit.constants import with_values
from magicsim.fit.equilibria import Equilibria
from magicsim.fit.observation import Observation
from magicsim.fit.strengths import Basis, Strengths, fit_strengths
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState, timeline
from magicsim.simulation.sensor import Sensor


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
    """States that the observations show.

    Raises:
        ConfigError: The scene has no such frame.
    """
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

    Args:
        scene: The sensor; its render settings say how well.
        values: Constants by dotted field.
        states: What to look at.
        equilibria: Keeps deformations.
        pair: Another number gives sets that are independent of those of this one.

    Raises:
        MagicsimError: The design, a deformation or an image is not valid.
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
    """Sets basis images beside observations, with the strengths of the lights that suit best.

    Args:
        bases: Two independent sets for each state.
        observations: Of the same states.
        camera: Tone curve and colour matrix.
        blocks: Down and across.
    """
    matrix = np.array(camera.color_matrix)
    both = [_mean(one, other) for one, other in bases]
    signals = [(each.mean / 255) ** camera.gamma for each in observations]
    strengths = fit_strengths(both, signals, matrix, blocks=blocks, gamma=camera.gamma)

    def grey(basis: Basis) -> Array:
        return np.asarray(255 * np.clip(strengths.signal(basis, matrix), 0, 1) ** (1 / camera.gamma))

    images = [(grey(one), grey(other)) for one, other in bases]
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


def _mean(one: Basis, other: Basis) -> Basis:
    return {name: np.asarray((image + other[name]) / 2, np.float32) for name, image in one.items()}
