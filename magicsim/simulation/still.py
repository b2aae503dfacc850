"""One radiance image of one frame of a scene, by one estimator alone: no anchor, no camera."""

import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from magicsim.arrays import FloatImage
from magicsim.config.ranges import check_number
from magicsim.errors import ConfigError
from magicsim.folder import check_file, result_file
from magicsim.light.variant import activate_variant
from magicsim.notebook import picture_row
from magicsim.notebook.screen import to_srgb
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState, timeline
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor, sensor_camera
from magicsim.simulation.stream import deformed
from magicsim.waiting import Told, on_stderr, waiting

STILL_SAMPLES = 32
"""Camera samples a pixel of a still at least, where the anchor has as many."""
LEAST_ERROR = 1e-6
"""Below the rounding of float32 images."""
WHITE = 99.0
"""Percentile that a notebook shows as white."""


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
    """The scene with more samples, the particles of the anchor, or both: a still stands alone."""
    render, changes = scene.render, {}
    if samples:
        changes["samples"] = max(render.samples, min(render.anchor_samples, STILL_SAMPLES))
    if particles:
        changes["particles"] = max(render.particles, render.anchor_particles)
    return scene.model_copy(update={"render": render.model_copy(update=changes)})


@dataclass(frozen=True, slots=True, kw_only=True)
class Rendering:
    """Linear radiance of one frame, and what it cost."""

    images: dict[str, FloatImage]
    """One image by the name of each light where a basis was asked for, else one under ``; (rows, columns, 3) each."""
    still: Still
    """Figures of the rendering."""

    @property
    def image(self) -> FloatImage:
        """All lights together, shape (rows, columns, 3)."""
        return np.asarray(np.sum(list(self.images.values()), axis=0, dtype=np.float32))

    def __repr__(self) -> str:
        """Size, lights and error; no arrays."""
        rows, columns, _ = self.image.shape
        return f"Rendering({columns} x {rows} pixels, {self.still})"

    def _repr_html_(self) -> str:
        """What a notebook shows: the image, its brightest hundredth cut off, in a screen's tone curve."""
        image = to_srgb(np.clip(self.image / max(float(np.percentile(self.image, WHITE)), 1e-30), 0, 1))
        return picture_row([((255 * image).astype(np.uint8), f"frame by {self.still.estimator}")])


def render(
    scene: SceneConfig, frame: int = 0, *, basis: bool = False, relative_error: float | None = None,
    told: Told = on_stderr,
) -> Rendering:  # fmt: skip
    """Renders the linear radiance of one scored frame.

    Args:
        scene: What happens; its render settings choose estimator, samples and particles.
        frame: Index among the scored frames.
        basis: Whether to render one image for each light.
        relative_error: Repeat the image with new random numbers until its mean is estimated to be so good, see
            `magicsim.light.plain_renderer`; not with `basis`.
        told: Hears what takes longer than two seconds.

    Raises:
        ConfigError: No such frame, or the error is not allowed.
        MagicsimError: The deformation or the image is not valid.
    """
    states = timeline(scene)
    if not 0 <= frame < len(states):
        raise ConfigError(f"frame = {frame} is not allowed: must be 0 to {len(states) - 1}")
    if relative_error is not None:
        check_number("relative_error", relative_error, LEAST_ERROR, 1)
        if basis:
            raise ConfigError(f"relative_error = {relative_error:g} is not allowed: must be without basis")
    with waiting(f"rendering frame {frame}", told):
        return _rendered(scene, states[frame], frame, basis=basis, relative_error=relative_error)


def _rendered(
    scene: SceneConfig, state: FrameState, frame: int, *, basis: bool, relative_error: float | None
) -> Rendering:
    if state.passing_mm is not None:
        raise ConfigError(f"frame = {frame} is not allowed: a still shows nothing that passes; take a still room")
    start = time.perf_counter()
    sensor = Sensor.for_scene(scene)
    if scene.rig.camera.live is not None:  # what `simulate` refuses is refused here too
        sensor_camera(sensor, sensor.radiance(UNTOUCHED, sensor.rest))
    deformation = sensor.rest
    for each in plan_scene(scene).frames[: frame + 1] if scene.contact.memory or scene.contact.friction else ():
        deformation = deformed(sensor, each, deformation)  # it depends on the way
    if state.can_touch and deformation.is_rest:
        deformation = sensor.deform(state, sensor.rest)
    view = sensor.view(state, deformation)
    sensor.renderer.warm_up(view)
    before = time.perf_counter()
    passes, error = 1, None
    if relative_error is not None:
        refinement = sensor.renderer.refined(view, relative_error)
        images, passes, error = {"": refinement.image}, refinement.passes, refinement.relative_error
    else:
        images = sensor.renderer.basis(view) if basis else {"": sensor.renderer.plain_radiance(view)}
    seconds = time.perf_counter() - before
    means = [image.mean((0, 1), dtype=np.float64) for image in images.values()]
    still = Still(
        seconds=seconds, seconds_total=time.perf_counter() - start, estimator=sensor.renderer.estimator,
        variant=activate_variant(), mean=np.sum([np.zeros(3), *means], axis=0).tolist(),
        lights=[name for name in images if name], passes=passes, relative_error=error, out=None,
    )  # fmt: skip
    return Rendering(images=images, still=still)


def render_still(
    scene: SceneConfig, frame: int, out: Path | None, *, basis: bool = False, relative_error: float | None = None,
    told: Told = on_stderr,
) -> Still:  # fmt: skip
    """Renders as `render`, into a file.

    Args:
        scene: What happens.
        frame: Index among the scored frames.
        out: File to write, or None: `.npy`, float32 of shape (rows, columns, 3); with `basis` `.npz`, one such array
            for each light by name.
        basis: Whether to render one image for each light.
        relative_error: See `render`.
        told: See `render`.

    Raises:
        ConfigError: No such frame, the file has another suffix, or the error is not allowed.
        OutputError: The file cannot be written; that is told before anything is rendered.
        MagicsimError: The deformation or the image is not valid.
    """
    suffix = ".npz" if basis else ".npy"
    if out is not None and out.suffix != suffix:
        raise ConfigError(f"out = '{out}' is not allowed: must end in {suffix}")
    if out is not None:
        check_file(out)
    found = render(scene, frame, basis=basis, relative_error=relative_error, told=told)
    if out is None:
        return found.still
    with result_file(out) as partial, partial.open("wb") as file:
        if basis:
            np.savez(file, **found.images)  # type: ignore[arg-type]
        else:
            np.save(file, found.images[""])
    return replace(found.still, out=str(out))
