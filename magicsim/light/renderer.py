"""Radiance of one sensor in any state, anchored to its untouched one, with as little work as the state needs."""

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from functools import cached_property, partial
from typing import Self

import numpy as np

from magicsim.arrays import Array, FloatImage, Mask, Numbers
from magicsim.camera.camera import Window
from magicsim.errors import RenderError
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import dr, in_rows, plain_errors
from magicsim.light.facing.finger import FacingFinger, FingerBody
from magicsim.light.facing.glow import Glow, facing_light
from magicsim.light.frame.frame_image import (
    REACH_PX,
    Look,
    anchored_change,
    anchored_image,
    own_field,
    passing_light_change,
)
from magicsim.light.frame.frame_light import Before, free_light, lifted, touched_light
from magicsim.light.plain_renderer import checked
from magicsim.light.reach import is_out_of_reach
from magicsim.light.records.untouched import UntouchedStates, default_store
from magicsim.light.rest_renderer import RestRenderer
from magicsim.light.transport.light_field import LightField
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.world.loaded_scene import Outside, Outsides
from magicsim.light.world.room_light import PassingLight
from magicsim.scenes.timeline import ALONE, AT_REST, LightOrigin, Origin, View

CLEAR_MM = 1e-3
"""An object that is not farther than this from the contact face may touch it [mm]."""
NO_CONTACT = SurfaceMesh(vertices=np.zeros((0, 3)), faces=np.zeros((0, 3), np.int32))
"""What a dent touches that an object has left: what it changes of the light in the block is less than noise."""
PASSING_PARTICLES_PART = 2
"""What passes gets the strips' particles divided by this."""


class Renderer(RestRenderer):
    """Owns the Mitsuba scenes of one elastomer on one rig, and untouched states that its frames refer to."""

    leaves_out_unmoved = True
    """Whether light and camera paths that meet nothing that moved are those of the untouched sensor; otherwise all are
    traced anew: for comparison. They always are where shadows of a dent fall on a coat that has not moved."""
    leaves_out_far = True
    """Whether an object that is too far to be seen is left out; otherwise it is rendered, for comparison."""
    leaves_out_noise = True
    """Whether changes of light and image are weighed by what is noise in them; otherwise all of them counts: right in
    the mean of many frames, as what is trained on them needs it."""
    _before: tuple[Array | None, float | None, Before] | None = None
    _passing: PassingLight | None = None

    @property
    def _keeps_unmoved(self) -> bool:
        return self.leaves_out_unmoved and not self.elastomer.design.is_opaque

    @cached_property
    def _outsides(self) -> Outsides:
        return Outsides(self.rig, self.object_mesh, self.object_finish, self.load_world)

    def reseeded(self, *, seed: int, anchor_seed: int | None = None) -> Self:
        """This renderer with other random numbers, its anchor's only if asked for.

        Both bring their views into the same Mitsuba scenes; those with one anchor share untouched states.
        """
        other = copy(self)
        other.seed, other._before = seed, None
        if anchor_seed is not None:
            other.settings = self.settings.model_copy(update={"anchor_seed": anchor_seed})
            other._untouched = UntouchedStates(default_store())
        return other

    def facing_another(self, other: Self, companion: SurfaceMesh | None = None) -> Self:
        """Renders this sensor with another one before it; untouched states are shared.

        Args:
            other: Renders the other one, which may be this.
            companion: What may be seen beside the object and touches nothing, with colours, in its own frame.
        """
        finger = FacingFinger.of(*other.as_finger(), self.object_mesh, self.object_finish, companion)
        return type(self)(
            self.elastomer, self.rig, self.settings, seed=self.seed, untouched=self._untouched, facing=finger
        )

    def as_finger(self) -> tuple[FingerBody, Glow]:
        """What another finger sees of this sensor at full light."""
        design = self.elastomer.design
        depth = design.height_mm + self.rig.lens.thickness_mm + self.rig.camera.distance_mm
        body = FingerBody.of(design.footprint_mm, depth)
        return body, Glow.of(self.light(View()), self.anchor().light, design, body.counts)

    def radiance(self, view: View) -> FloatImage:
        """Linear radiance of what is read out, shape (rows, columns, 3), anchored if settings say so.

        Raises:
            RenderError: The image holds values that are not finite.
        """
        return self.render(view)[0]

    @plain_errors()
    def render(self, view: View) -> tuple[FloatImage, Origin]:
        """Radiance of a view, and the origin of its light.

        Raises:
            RenderError: The image holds values that are not finite.
        """
        if not self.is_anchored:
            if view.passing_mm is not None:
                raise RenderError(f"what passes in a room needs recorded light; estimator '{self.estimator}' has none")
            return self.plain_radiance(view), ALONE
        shown = self.within_reach(view)
        ideal, origin = self._ideal(shown)
        image = self.film.seen(checked(ideal))
        if view.passing_mm is None:
            return image, origin
        change = self.film.seen(self._passing_change(shown, self.passing_light(view.passing_mm)))
        changed = np.asarray(np.maximum(image + change, 0), np.float32)
        return changed, Origin(light="outside", image="recorded") if origin == AT_REST else origin

    def warm_up(self, view: View) -> None:
        """Compiles what a view of this kind needs, and computes what all such frames share."""
        if self.is_anchored:
            self.radiance(view)
        else:
            few = {"samples": 1, "particles": 64}
            warm = copy(self)
            warm.settings = self.settings.model_copy(update=few)
            warm.plain_radiance(view)

    def prepare(self, view: View) -> None:
        """Computes what all frames like this one share: the untouched sensor, carefully and with a frame's numbers."""
        if self.is_anchored:
            self.anchor()
            if not self.within_reach(view).is_untouched:
                self.control()

    def _ideal(self, view: View) -> tuple[FloatImage, Origin]:
        """Radiance of the window of the ideal image that is looked at, shape (rows, columns, 3); how it was made."""
        anchor = self.anchor()
        if view.is_untouched:
            return np.asarray(self.film.window.of(anchor.image)), AT_REST
        if self.elastomer.design.is_opaque:
            return self._coated(view)
        pixels = self._around.numbers(self.film.columns, self.film.rows)
        rest, placed, light_x_mm = self.light(View()), self.placed(view), view.flashlight_x_mm
        self.check_room(view, placed)
        is_moved = self.is_moved(view, placed)
        field, light_origin = self._light(view, placed, is_moved=is_moved)
        origin = Origin(light=light_origin, image="recorded")
        look = Look(
            world=rest, outside=self.outside(placed, light_x_mm), field=field, samples=self.settings.samples,
            seed=self.seed,
        )  # fmt: skip
        if not is_moved:
            return self._inner(look.through(anchor, pixels)), origin
        changed, traced = self._changed(view, placed, pixels), None
        if changed.any():
            traced = self.light(view).gather_pixels(
                field, pixels[changed], samples=self.settings.samples, seed=self.seed, pattern=self.seed
            )
            dr.eval(traced)  # begins, while the rest is computed
            origin = replace(origin, image="traced")
        control = self.control()
        before, known = (look.through(each, pixels) for each in (anchor, control))
        now = known.copy()
        if traced is not None:
            now[changed] = in_rows(traced)
        whole, control_image, anchor_image = (self._as_image(each) for each in (now, known, before))
        if self.leaves_out_noise:
            found = anchored_image(whole, control_image, anchor_image, changed.reshape(whole.shape[:2]))
        else:
            found = anchor_image + whole - control_image
        return self._inner(found), origin

    @cached_property
    def _around(self) -> Window:
        """Window of the ideal image that what is looked at depends on."""
        return self.film.window.grown(REACH_PX, self.film.columns, self.film.rows)

    def _as_image(self, pixels: Array | FloatImage) -> FloatImage:
        return np.asarray(pixels.reshape(self._around.rows, self._around.columns, 3), np.float32)

    def _inner(self, around: Array | FloatImage) -> FloatImage:
        """What is looked at of the pixels around it, shape (rows, columns, 3)."""
        return np.asarray(self.film.window.within(self._around).of(self._as_image(around)))

    def _coated(self, view: View) -> tuple[FloatImage, Origin]:
        """Radiance of an opaque coat, whose frames have no noise that an untouched image could take away."""
        world, window, origin = self.light(view), self.film.window, Origin(light="traced", image="traced")
        if world.is_integrated:
            field = world.darkness()
        else:
            field, light = self._light(view, self.placed(view), is_moved=True)
            world, origin = self.light(view), replace(origin, light=light)
        seen = world.gather(field, samples=self.settings.samples, seed=self.seed, pattern=self.seed, window=window)
        return np.array(seen, np.float32), origin

    def passing_light(self, x_mm: float) -> PassingLight:
        """What passes in the room, in its place along x."""
        if self._passing is None:
            passing = self.rig.moving
            assert passing is not None
            self._passing = PassingLight(passing, self.world(View()).scene.environment(), self.rig.room_light)
        self._passing.place(x_mm)
        return self._passing

    def _passing_change(self, view: View, light: PassingLight) -> FloatImage:
        """What something that passes changes of the window of the ideal image, shape (rows, columns, 3).

        Rendering is linear in light, so records, light and frames of the still room serve as they are. The change is
        computed by itself, with the sensor's own lights off: particles from where the thing is, what they leave in the
        block and on the object, and what recorded camera paths meet of it. All its places share their random numbers,
        so the change moves as smoothly as the thing does.
        """
        pixels = self._around.numbers(self.film.columns, self.film.rows)
        placed, samples = self.placed(view), self.settings.samples
        field = self._passing_field(view, placed, light)
        look = Look(
            world=self.light(View()), outside=self.outside(placed, view.flashlight_x_mm), field=field,
            samples=samples, seed=self.seed, passing=light,
        )  # fmt: skip
        before = look.through(self.anchor(), pixels)
        if not self.is_moved(view, placed):
            return self._inner(before)
        known, changed = look.through(self.control(), pixels), self._changed(view, placed, pixels)
        now = known.copy()
        if changed.any():
            traced = self.light(view).gather_pixels(
                field, pixels[changed], samples=samples, seed=self.seed, pattern=self.seed, room=light
            )
            now[changed] = in_rows(traced)
        whole, control_image, anchor_image = (self._as_image(each) for each in (now, known, before))
        found = anchored_change(whole, control_image, anchor_image, changed.reshape(whole.shape[:2]))
        return self._inner(found)

    def _passing_field(self, view: View, placed: Array | None, light: PassingLight) -> LightField:
        """What something that passes changes of the light in the block and on the object.

        The change in a touched block is that of the last state before contact: a press changes by some per cent what is
        some per cent itself.
        """
        world, anchor = self.light(View()), self.anchor()
        is_moved, particles = self.is_moved(view, placed), self.settings.particles
        outside = self.outside(self._free(view, placed) if is_moved else placed, view.flashlight_x_mm)
        field = passing_light_change(
            world, outside, light, own_field(world, anchor), particles=max(1, particles // PASSING_PARTICLES_PART),
            seed=self.seed,
        )  # fmt: skip
        if is_moved:
            world = self.light(view)
            field = replace(field, body=world.growth(anchor.held_mm3) * field.body)
        return world.with_lit_object(
            field, particles=particles, seed=self.seed, outside=None if is_moved else outside, room=light
        )

    def is_moved(self, view: View, placed: Array | None) -> bool:
        """Whether a view needs paths through the block as it is deformed."""
        return not view.is_undeformed or self._may_touch(placed) or not self._keeps_unmoved

    def _light(self, view: View, placed: Array | None, *, is_moved: bool) -> tuple[LightField, LightOrigin]:
        """Light in the block and on the object, and where it comes from."""
        rest, anchor, control = self.light(View()), self.anchor(), self.control()
        particles, seed = self.settings.particles, self.seed
        if not is_moved:
            outside = self.outside(placed, view.flashlight_x_mm)
            free = free_light(rest, outside, anchor, control, particles=particles, seed=seed)
            return self._on_object(view, rest, free, outside), "outside"
        # First, as a dent without an object is seen in the scene of the untouched block.
        before = self._before_contact(self._free(view, placed), view.flashlight_x_mm)
        touched = self.light(view)
        contact = self.contact(placed) if self.leaves_out_noise else None
        if view.is_released and contact is None and not self.elastomer.design.is_opaque:
            contact = NO_CONTACT
        field, origin = touched_light(
            touched, before, anchor, contact, least=self.settings.light_change,
            particles=particles, seed=seed,
        )  # fmt: skip
        return self._on_object(view, touched, field, None), origin

    def _on_object(self, view: View, world: LitWorld, field: LightField, outside: Outside | None) -> LightField:
        """The light with a facing finger's, and with what falls on the object gathered by rays from its surface."""
        particles, seed, facing = self.settings.particles, self.seed, self._facing
        if facing is None or view.facing_mm is None:
            return world.with_lit_object(field, particles=particles, seed=seed, outside=outside)
        added = facing_light(
            world, outside, facing.glow, view.facing_mm, self.elastomer.design.footprint_mm, seed=seed, most=particles
        )
        before = facing.shining(field, added)
        return facing.gathered(before, world.with_lit_object(before, particles=particles, seed=seed, outside=outside))

    def _free(self, view: View, placed: Array | None) -> Array | None:
        """The object where it last did not touch."""
        if placed is None or not self._may_touch(placed):
            return placed
        return lifted(placed) if self._facing is None else self._facing.lifted(view, placed)

    def _touching(self, placed: Array) -> Array:
        """Vertices of what may touch: the object's, all others being behind it."""
        return placed if self._facing is None else placed[: len(self._facing.object_vertices)]

    def _may_touch(self, placed: Array | None) -> bool:
        """Whether an object is so close to the contact face that it may touch it."""
        return placed is not None and bool(self._touching(placed)[:, 2].max(initial=-np.inf) >= -CLEAR_MM)

    def contact(self, placed: Array | None) -> SurfaceMesh | None:
        """The object's surface where it may touch, None without an object."""
        if placed is None or self.object_mesh is None:
            return None
        faces = self.object_mesh.faces
        is_near = (placed[faces, 2] >= -CLEAR_MM).any(1) & (faces[:, 0] < len(self._touching(placed)))
        return SurfaceMesh(vertices=placed, faces=faces[is_near])

    def _before_contact(self, placed: Array | None, light_x_mm: float | None) -> Before:
        """Light of the last state before contact, kept for other depths of one press."""
        kept = self._before
        if kept is None or kept[1] != light_x_mm or not np.array_equal(_known(kept[0]), _known(placed)):
            light = Before(
                world=self.light(View()), placed=self._putting_outside(placed, light_x_mm), rest=self.anchor(),
                control=self.control(), seed=self.seed,
            )  # fmt: skip
            self._before = kept = (placed, light_x_mm, light)
        return kept[2]

    def outside(self, placed: Array | None, light_x_mm: float | None) -> Outside:
        """What stands before the block, in its place; a ghost is nothing there."""
        return self._putting_outside(placed, light_x_mm)()

    def _putting_outside(self, placed: Array | None, light_x_mm: float | None) -> Callable[[], Outside]:
        """Puts it there when it is called; it does not hold this renderer, whose memory is large."""
        return partial(self._outsides.of, None if self.object_finish.is_ghost else placed, light_x_mm)

    def _changed(self, view: View, placed: Array | None, pixels: Numbers) -> Mask:
        """Which pixels have a path of the control record that met something that has moved, shape (pixels,)."""
        if not self._keeps_unmoved:
            return np.ones(len(pixels), bool)
        paths = self.control().paths
        regions = paths.regions
        assert regions is not None
        moved = np.zeros(int(np.prod(regions.counts)), bool)
        for mesh, now in ((self.elastomer.body, view.body), (self.elastomer.infill, view.infill)):
            if mesh is not None and now is not None:
                far = np.linalg.norm(now - mesh.vertices, axis=1) > self.settings.reuse_mm
                moved |= regions.reached(mesh.vertices, mesh.faces[far[mesh.faces].any(1)])
        contact = self.contact(placed)
        if contact is not None:
            moved |= regions.reached(contact.vertices, contact.faces)
        return paths.meet(regions.bits(moved), pixels)

    def within_reach(self, view: View) -> View:
        """The view without an object that is too far to be seen."""
        placed = self.placed(view)
        if placed is None or not self.leaves_out_far or self._facing is not None:
            return view
        gap_mm, design = -float(placed[:, 2].max()), self.elastomer.design
        is_gone = is_out_of_reach(gap_mm, self.object_finish, design, self.rig, self.metered())
        return replace(view, indenter=None) if is_gone else view


def _known(placed: Array | None) -> Array:
    return np.zeros((0, 3)) if placed is None else placed
