"""The fast tier of one sensor: a touched picture as the network of its model sees it, without tracing a ray of it.

The picture is that of the object just before contact, by recorded paths as always, and the change that the model says.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, FloatImage, Mask
from magicsim.emulator.fields import FieldMaker
from magicsim.emulator.model import ALL, SAME_REST, TouchModel, coarse, find_model, rest_key
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.rigid_object import ObjectBase
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import ContactSettings, RenderSettings
from magicsim.scenes.timeline import FrameState, Origin, TierError

EMULATED = Origin(light="before contact", image="emulated")
OFF = "the fast tier is off by"
"""How the error begins that stops a dataset."""
STATED = 3.0
"""A frame may be off by so many times what the model says of all touches that it never saw, the noise of true frames
included."""


@dataclass(slots=True, kw_only=True)
class Emulator:
    """Pictures of one sensor's touches."""

    model: TouchModel
    fields: FieldMaker
    kept: tuple[FrameState, FloatImage] | None = field(default=None)
    """The last state before contact that was rendered, and its radiance: depths of one press share it."""

    @classmethod
    def of(
        cls, model: TouchModel, design: ElastomerDesign, rig: Rig, image: FloatImage, fields: Callable[[], FieldMaker]
    ) -> Self | str:  # fmt: skip
        """For a sensor, or why its untouched image is none that the model knows.

        Args:
            model: See `known_model`.
            design: The block.
            rig: What surrounds it.
            image: Radiance of the untouched sensor, shape (rows, columns, 3).
            fields: Gives what makes its fields.
        """
        if (
            rest_key(design, rig) == model.facts.rest_key
            and (off := _difference(coarse(image), model.rest)) > SAME_REST
        ):
            return f"the untouched image differs by {off:.1%} from the one that its model was made with, by other code"
        return cls(model=model, fields=fields())

    def refusal(self, state: FrameState) -> str | None:
        """Why a touch is none that the model knows; None where it is."""
        depth = -(state.gap_mm or 0.0)
        if depth > self.model.facts.depth_mm:
            return f"a touch {depth:g} mm deep is deeper than the {self.model.facts.depth_mm:g} mm that its model knows"
        if state.flashlight or state.facing_mm is not None or state.companion is not None:
            return "a touch under a flashlight or before another finger is none that its model knows"
        return None

    @property
    def bound(self) -> float:
        """What a frame may be off by in the mean [linear grey levels]."""
        rows = [row for row in self.model.facts.errors if row.states == ALL]
        return STATED * float(np.hypot(rows[0].error, rows[0].true_tier)) if rows else np.inf

    def radiance(
        self, free: FrameState, displacements_mm: npt.NDArray[np.float32], mask: Mask,
        render: Callable[[FrameState], FloatImage],
    ) -> FloatImage:  # fmt: skip
        """Radiance of a touch, shape (rows, columns, 3).

        Args:
            free: The state with the object just before contact.
            displacements_mm: Of the design's lattice, shape (nodes, 3) [mm].
            mask: Where the face touches the object, shape (rows, columns).
            render: Gives the radiance of that state, shape (rows, columns, 3).
        """
        if self.kept is None or self.kept[0] != free:
            self.kept = (free, render(free))
        before = self.kept[1]
        fields, gate = self.fields.make(displacements_mm, before, mask)
        change = self.fields.scale * gate[..., None] * self.model.predict(fields)
        return np.asarray(np.maximum(before + change, 0), np.float32)


def unknown_sensor(design: ElastomerDesign, rig: Rig, contact: ContactSettings) -> str | None:
    """Why no model can know a sensor, whatever it was distilled from; None where one may. See `known_model`."""
    camera = rig.camera
    for is_unknown, what in (
        (design.is_opaque or design.face is not None, "a face with a coat or a shape"),
        (contact.coupling != "wet", "contact.coupling = 'dry'"),
        (contact.rate_dependent or contact.keeps_dent, "a material that relaxes or yields"),
        (camera.region_px is not None or camera.glare is not None, "a picture with camera.region_px or glare"),
        (camera.columns % 2 or camera.rows % 2, f"an odd picture of {camera.columns} x {camera.rows} pixels"),
    ):
        if is_unknown:
            return f"{what} is none that a model knows"
    return None


def known_model(
    design: ElastomerDesign, rig: Rig, target: ObjectBase | None, contact: ContactSettings, settings: RenderSettings
) -> TouchModel | str:  # fmt: skip
    """The model of a sensor's touches, or why there is none; single frames may still be none that it knows.

    Args:
        design: The block.
        rig: What surrounds it.
        target: What may touch it.
        contact: How both meet.
        settings: Which model.

    Raises:
        ConfigError: The named file does not exist or is not a model.
    """
    if (problem := unknown_sensor(design, rig, contact)) is not None:
        return problem
    model, reason = find_model(settings.model, design, rig)
    if model is None:
        return reason
    facts = model.facts
    gloss, spacing = getattr(target, "specular", 0.0), getattr(target, "spacing_mm", np.inf)
    if gloss > facts.specular:
        return f"object.specular = {gloss:g} is more than the {facts.specular:g} that its model knows"
    if np.isfinite(spacing) and facts.spacing_mm == 0:
        return f"object.spacing_mm = {spacing:g} is not known: its model learned from no texture"
    if spacing < facts.spacing_mm:
        return f"object.spacing_mm = {spacing:g} is finer than the {facts.spacing_mm:g} that its model knows"
    return model


def compared(image: FloatImage, true: FloatImage, gain: Array) -> TierError:
    """How far an image is off a true one, both linear radiance.

    Args:
        image: Shape (rows, columns, 3).
        true: Of the same shape.
        gain: Grey levels of each channel's radiance, shape (3,).
    """
    off = np.abs(gain * (image.astype(np.float64) - true))
    return TierError(float(off.mean()), *(float(np.percentile(off, share)) for share in (95, 99)))


def _difference(first: npt.NDArray[np.float32], second: npt.NDArray[np.float32]) -> float:
    if first.shape != second.shape:
        return float("inf")
    return float(np.sqrt(np.mean((first - second) ** 2)))
