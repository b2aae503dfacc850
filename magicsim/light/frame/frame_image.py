"""Image of one frame from recorded camera paths: what light and things outside change of the untouched sensor's image.

A path serves as long as no surface that it meets inside the block has moved. What it then meets outside, and the light
that it gathers on its way, are those of the frame. Where a press has moved something on a pixel's way, its paths are
traced anew, with the random numbers of recorded ones: what both differ by is the change (`anchored_image`).

Frames of an episode share their random numbers. Where nothing changed a frame has the very noise of the untouched
sensor's control image; where the grid is deformed its camera paths are others, and taking that noise off would add it.
So the share of the noise that both have is found from the images themselves, and how much of what is left is noise
follows from it: where that is most of what seems to have changed, little of it is shown.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from magicsim.arrays import Array, FloatImage, Mask, Numbers
from magicsim.camera.camera import Window
from magicsim.light.backend import dr
from magicsim.light.frame.anchored_light import mean_of_cells
from magicsim.light.records.untouched import Untouched
from magicsim.light.transport.light_field import LightField, total
from magicsim.light.transport.light_pass import sum_tracks
from magicsim.light.transport.light_starts import FIXED_POINT, ROUND_OBJECT, LightStarts, Sent, chunks
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.transport.streams import MIRRORED, PASSING, PASSING_ON_OBJECT, SEEDS_PER_RENDER
from magicsim.light.world.loaded_scene import Outside
from magicsim.light.world.names import ENVIRONMENT
from magicsim.light.world.room_light import PassingLight, PassingPart

SPREAD_PX = 6.0
"""Standard deviation of the weights of neighbouring pixels [px]: half as much is noisier, more blurs what is local."""
NEAREST_PX = 12
"""Largest distance of such a neighbour along columns and rows [px]."""
LENGTHS_PX = (0.0, 2.0, 12.0)
"""Standard deviations of the local means along columns and along rows between which a change is taken apart [px]: walls
are about a pixel wide and stand along either, and what is smoother than the last both ways has hardly any noise. More
lengths between these, or longer ones, leave 1 to 3 % less error and cost twice the time."""
LENGTH_REACH_PX = 24
"""Largest distance of a pixel that such a mean takes in [px]."""
REACH_PX = 2 * NEAREST_PX + LENGTH_REACH_PX
"""Largest distance of a pixel that has a part in another's image along columns and rows [px]."""


def anchored_image(now: FloatImage, control: FloatImage, anchor: FloatImage, changed: Mask) -> FloatImage:
    """The anchor's image and the change that a frame shows, less shared noise.

    Detail keeps its contrast where it is more than noise (`benchmarks/detail.py`).

    Args:
        now: Radiance of the frame, shape (rows, columns, 3).
        control: The untouched sensor with the frame's random numbers and samples, of the same shape.
        anchor: The untouched sensor with many samples, of the same shape.
        changed: Which pixels the frame can change, shape (rows, columns); the others are the anchor ones.
    """
    change = anchored_change(now, control, anchor, changed)
    return np.where(changed[..., None], np.maximum(change, 0), change)


def anchored_change(now: FloatImage, control: FloatImage, anchor: FloatImage, changed: Mask) -> FloatImage:
    """`anchored_image` of values that may be negative, as those are that one light changes."""
    result = anchor.copy()
    if not changed.any():
        return result
    rows, columns = (np.flatnonzero(changed.any(axis)) for axis in (1, 0))
    box = Window(
        column=int(columns[0]), row=int(rows[0]), columns=int(np.ptp(columns)) + 1, rows=int(np.ptp(rows)) + 1
    ).grown(REACH_PX, changed.shape[1], changed.shape[0])
    change = change_beyond_noise(*(box.of(each) for each in (now, control, anchor)))
    box.of(result)[...] = np.where(box.of(changed)[..., None], box.of(anchor) + change, box.of(anchor))
    return result


def change_beyond_noise(now: FloatImage, control: FloatImage, anchor: FloatImage) -> Array:
    """How a frame differs from the untouched sensor as far as it is no noise, shape (rows, columns, 3).

    The difference is taken apart by length along columns and by length along rows: what a wall changes is long one way
    and short the other, and noise is short both ways. Of each part goes first the noise that both images share: its
    share is the linear regression on the control image's noise over all neighbours, with a constant for each channel.
    What is left has noise of variance n^2 = (1 - share^2) times that of the control image, and a mean square v over the
    neighbours. It counts by 1 - n^2 / v (Wiener's filter with the variance of the signal estimated where it is used),
    the part that is smoothest both ways wholly.

    A pixel's own values are left out, so that its own noise chooses neither its share nor its weight. Near the border
    the mirror brings them back with a weight of 1 % at most. Every pixel sums in one order: crops are exact.
    """
    changes, noises = (_by_length(each.astype(np.float64) - anchor) for each in (now, control))
    *fine, smooth = (_without_shared_noise(*each) for each in zip(changes, noises, strict=True))
    change = smooth[0]
    for part, own_noise in fine:
        squares = _of_neighbours(_summed(part**2))
        noise_part = np.divide(own_noise, squares, out=np.ones_like(squares), where=squares > 0)
        change = change + part * np.maximum(1 - noise_part, 0)
    return np.asarray(change)


def _by_length(values: Array) -> list[Array]:
    """Parts by length along columns and rows, the smoothest both ways last; their sum is what is given."""
    return [part for along in _along(values, 0) for part in _along(along, 1)]


def _along(values: Array, axis: int) -> list[Array]:
    """Differences between local means of growing width along one axis, and the widest."""
    means = [
        gaussian_filter1d(values, width, axis=axis, mode="mirror", radius=LENGTH_REACH_PX) if width else values
        for width in LENGTHS_PX
    ]
    return [fine - coarse for fine, coarse in pairwise(means)] + means[-1:]


def _without_shared_noise(changed: Array, noise: Array) -> tuple[Array, Array]:
    """A change less the noise that it shares, and the variance of the noise that it still has around each pixel."""
    around_changed, around_noise = _of_neighbours(changed), _of_neighbours(noise)
    # Over all channels together: the mean over neighbours of a sum is the sum of their means.
    shared = _of_neighbours(_summed(changed * noise)) - _summed(around_changed * around_noise)
    variance = np.maximum(_of_neighbours(_summed(noise**2)) - _summed(around_noise**2), 0)
    share = np.clip(np.divide(shared, variance, out=np.zeros_like(shared), where=variance > 0), 0, 1)
    return changed - share * noise, (1 - share**2) * variance


def _summed(values: Array) -> Array:
    """Over the channels, shape (rows, columns, 1)."""
    return np.asarray(values.sum(2, keepdims=True))


def _of_neighbours(values: Array) -> Array:
    """Weighted mean over the pixels around each, without itself, in every channel."""
    pulse = np.zeros(2 * NEAREST_PX + 1)
    pulse[NEAREST_PX] = 1
    own = float(gaussian_filter1d(pulse, SPREAD_PX, radius=NEAREST_PX)[NEAREST_PX]) ** 2
    # Mirrored at the border, which the mean then does not count again.
    around = gaussian_filter(values, SPREAD_PX, mode="mirror", radius=NEAREST_PX, axes=(0, 1))
    return np.asarray((around - own * values) / (1 - own))


SIGNS = (1.0, -1.0)
SPREAD_CELLS = 1.5
"""Standard deviation of that Gaussian [cells]: below a scattering free path of 3 mm."""
MIRRORED_PER_SAMPLE = 3
"""Paths that a glossy object sends on, for each camera sample: its highlights are small and bright."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """What a frame shows to paths through the untouched block."""

    world: LitWorld
    """The scene with nothing before the block."""
    outside: Outside
    """What stands there."""
    field: LightField
    """Light in the block and on the object."""
    samples: int
    """Camera samples of each pixel that are traced on where the object mirrors."""
    seed: int
    passing: PassingLight | None = None
    """What passes, in its place, if what it changes is looked at: `field` is then its change of the light."""

    def through(self, rest: Untouched, pixels: Numbers) -> Array:
        """Radiance of some pixels by the paths of one record, or its change by what passes, shape (pixels, 3)."""
        paths, world, outside, field = rest.paths, self.world, self.outside, self.field
        finish, passing = world.content.object_finish, self.passing
        if passing is None:
            own = own_field(world, rest)
            change = LightField(
                fluence=field.fluence - own.fluence, body=field.body - own.body, irradiance=own.irradiance
            )
            seen = paths.glow(world.elements(change), pixels)
            seen += paths.seen_outside(world.inventory.environment, outside, field.irradiance, finish, pixels)
        else:
            seen = paths.glow(world.elements(field), pixels)
            seen += paths.seen_of_room(passing, pixels)
            if outside.is_there:
                seen += paths.seen_outside(None, outside, field.irradiance, finish, pixels, room=passing)
        seen += paths.mirrored(
            outside, finish, pixels, lambda starts: world.camera_pass(
                field, starts, stream=SEEDS_PER_RENDER * self.seed + MIRRORED, outside=outside, room=passing
            ), samples=MIRRORED_PER_SAMPLE * self.samples, seed=self.seed,
        )  # fmt: skip
        return np.asarray(seen if passing is not None else np.maximum(rest.image.reshape(-1, 3)[pixels] + seen, 0))


def own_field(world: LitWorld, rest: Untouched) -> LightField:
    """Light of all lights of the untouched sensor."""
    return total([world.darkness(), *rest.fields.values()])


def room_part(world: LitWorld, rest: Untouched, pixels: Numbers) -> FloatImage:
    """What the room's light makes of some pixels of the untouched image, shape (pixels, 3).

    The share that it has of what recorded paths see, of the image that has more of them.
    """
    own, room = own_field(world, rest), rest.fields[ENVIRONMENT]
    paths, light = rest.paths, replace(own, fluence=room.fluence, body=room.body)
    whole = paths.direct[pixels] + paths.glow(world.elements(own), pixels)
    seen = paths.glow(world.elements(light), pixels) + paths.seen_of_room(world.inventory.environment, pixels)
    share = np.divide(seen, whole, out=np.zeros_like(seen), where=whole > 0).clip(0, 1)
    return np.asarray(share * rest.image.reshape(-1, 3)[pixels], np.float32)


def passing_light_change(
    world: LitWorld, outside: Outside, light: PassingLight, rest: LightField, *, particles: int, seed: int
) -> LightField:
    """Change of the light in the untouched block and on what stands before it; values of either sign.

    Noise is spread over neighbouring cells, see `spread`.
    """
    sent, shares = [], ((1.0, PASSING), (ROUND_OBJECT, PASSING_ON_OBJECT))
    for place, sign in enumerate(SIGNS):
        for beam, (share, stream) in zip(world.inventory.beams(outside), shares, strict=False):
            count, part = max(1, round(share * particles)), PassingPart(light, sign)
            sent.append(Sent(part, 0, count, SEEDS_PER_RENDER * seed + stream, False, place, beam, particles / count))
    tracks = [
        world.light_pass(starts.some(kept), lights=len(SIGNS), outside=outside)
        for chunk in chunks(sent)
        if len(kept := dr.compress((starts := LightStarts.emitted(chunk)).brightest > 0))
    ]
    if not tracks:
        return world.darkness(outside)
    found, scale = sum_tracks(tracks), 1 / (FIXED_POINT * particles)
    # What the positive part left less what the negative part did.
    parts = [each.astype(np.float64) for each in (found.cells, found.body, found.landed)]
    cells, body, landed = (scale * (plus - minus) for plus, minus in parts)
    change, voxels = world.deposited(cells, body, landed, outside), world.voxel_counts
    body = spread(body, rest.body, voxels) if voxels is not None else body
    return replace(change, fluence=spread(change.fluence, rest.fluence, world.counts), body=body)


def spread(change: Array, level: Array, counts: tuple[int, int, int]) -> Array:
    """A noisy change of light, spread over neighbouring cells in proportion to the light that is there; its sum stays.

    Each cell's change goes to its neighbours by a Gaussian's weights times their level: what changes light from cell to
    cell is the grid, and that of the untouched sensor is known.
    """
    # Reflected at the rim, weights are the same both ways.
    around = mean_of_cells(level, counts, SPREAD_CELLS, mode="reflect")
    share = np.divide(change, around, out=np.zeros_like(change), where=around > 0)
    return np.where(around > 0, level * mean_of_cells(share, counts, SPREAD_CELLS, mode="reflect"), change)
