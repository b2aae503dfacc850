"""One radiance image of one frame of a scene, by one estimator alone: no anchor, no camera."""

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from magicsim.config.ranges import check_number
from magicsim.errors import ConfigError
from magicsim.folder import result_file
from magicsim.light.variant import activate_variant
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import timeline
from magicsim.simulation.plan import can_touch
from magicsim.simulation.sensor import Sensor

LEAST_ERROR = 1e-6
"""Below the rounding of float32 images."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Still:
    """What `magicsim render` reports."""

    seconds: float
    """Warm cost of light and camera pass [s]."""
    seconds_total: float
    """Everything, with geometry, deformation and compilation [s]."""
    estimator: str
    variant: str
    mean: list[float]
    """Mean radiance of each channel, of all lights together."""
    lights: list[str]
    """Names of the basis images, empty without them."""
    passes: int
    """Independent images that were averaged."""
    relative_error: float | None
    """Estimated from their spread; None of a single image."""
    out: str | None
    """File written, None without one."""


def with_care(scene: SceneConfig, *, samples: bool, particles: bool) -> SceneConfig:
    """The scene with the samples, the particles or both raised to those of the anchor: a still stands alone.

    Args:
        scene: What happens.
        samples: Whether to raise the camera samples.
        particles: Whether to raise the light particles.
    """
    render, changes = scene.render, {}
    if samples:
        changes["samples"] = max(render.samples, render.anchor_samples)
    if particles:
        changes["particles"] = max(render.particles, render.anchor_particles)
    return scene.model_copy(update={"render": render.model_copy(update=changes)})


def render_still(
    scene: SceneConfig, frame: int, out: Path | None, *, basis: bool = False, relative_error: float | None = None
) -> Still:
    """Renders the linear radiance of one scored frame.

    Args:
        scene: What happens; its render settings choose estimator, samples and particles.
        frame: Index among the scored frames.
        out: File to write, or None: `.npy`, float32 of shape (rows, columns, 3); with `basis` `.npz`, one such array
            for each light by name.
        basis: Whether to render one image for each light.
        relative_error: Repeat the image with new random numbers until its mean is estimated to be so good, see
            `magicsim.light.refinement`; not with `basis`.

    Raises:
        ConfigError: No such frame, the file has another suffix, or the error is not allowed.
        MagicsimError: The deformation or the image is not valid.
    """
    start = time.perf_counter()
    states = timeline(scene)
    if not 0 <= frame < len(states):
        msg = f"frame = {frame} is not allowed: must be 0 to {len(states) - 1}"
        raise ConfigError(msg)
    suffix = ".npz" if basis else ".npy"
    if out is not None and out.suffix != suffix:
        msg = f"out = '{out}' is not allowed: must end in {suffix}"
        raise ConfigError(msg)
    if relative_error is not None:
        check_number("relative_error", relative_error, LEAST_ERROR, 1)
        if basis:
            msg = f"relative_error = {relative_error:g} is not allowed: must be without basis"
            raise ConfigError(msg)
    state = states[frame]
    sensor = Sensor(scene)
    deformation = sensor.deform(state, sensor.rest) if can_touch(state) else sensor.rest
    view = sensor.view(state, deformation)
    sensor.renderer.warm_up(view)
    before = time.perf_counter()
    refinement = sensor.renderer.refined(view, relative_error) if relative_error is not None else None
    if refinement is not None:
        images = {"": refinement.image}
    else:
        images = sensor.renderer.basis(view) if basis else {"": sensor.renderer.plain_radiance(view)}
    seconds = time.perf_counter() - before
    if out is not None:
        with result_file(out) as partial, partial.open("wb") as file:
            if basis:
                np.savez(file, **images)  # type: ignore[arg-type]
            else:
                np.save(file, images[""])
    return Still(
        seconds=seconds,
        seconds_total=time.perf_counter() - start,
        estimator=sensor.renderer.estimator,
        variant=activate_variant(),
        mean=np.sum(
            [np.zeros(3), *(image.mean((0, 1), dtype=np.float64) for image in images.values())], axis=0
        ).tolist(),
        lights=[name for name in images if name],
        passes=refinement.passes if refinement is not None else 1,
        relative_error=refinement.relative_error if refinement is not None else None,
        out=str(out) if out is not None else None,
    )
