"""What a touch changes of the light from the strips, in a block whose grid is taken as one turbid medium.

Walls turn light at every millimetre, so that a moved wall makes other paths of all that follows, and the particles of
a frame measure noise. Without walls a path is another one only from where it meets the dent on: each particle is
followed through the untouched block until then, and from there both ways with the same random numbers; what they leave
differently in the cells is the change. A particle that never meets the dent brings none, and no noise.

The medium scatters as the infill does in its share of the core (isotropic), absorbs as both do on the mean and has the
index of the walls. Faces: what touches sends back a diffuse share, the bare face what Fresnel's formulas say, the sides
the strips' reflectance (diffuse), the lens what its outer face reflects.
"""

# mypy: allow-untyped-defs
# ruff: noqa: ANN001, ANN202 -- numba infers the types of the kernels.

from dataclasses import dataclass

import cv2
import numba as nb
import numpy as np
import numpy.typing as npt
from scipy.interpolate import RegularGridInterpolator, griddata
from scipy.ndimage import gaussian_filter

from magicsim.deform.deformation import Deformation
from magicsim.scenes.timeline import FrameState, View
from magicsim.simulation.sensor import Sensor

Array = npt.NDArray[np.float64]
STEP_MM = 0.1
"""Of the map of the face's heights [mm]."""
BIN_MM = 1.0
"""Edge of the boxes in which light is counted, about [mm]."""
FLAT_MM = 1e-3
"""Height below which the face counts as untouched [mm]."""
CHUNKS = 16
"""Parts of the particles, each counted by itself: sums do not depend on threads."""
MOST_EVENTS, LEAST_WEIGHT, ENDS = 300, 0.02, 0.5
"""Most flights of a particle; weight below which half of them end (Russian roulette)."""
UNTOUCHED, DENTED = 0, 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """What particles meet."""

    size_mm: tuple[float, float, float]
    lens_mm: float
    core_mm: tuple[float, float]
    """Depths between which the medium scatters."""
    scattering_per_mm: float
    absorption_per_mm: float
    ior: float
    reflectance: float
    """Diffuse, of the sides."""

    @classmethod
    def of(cls, sensor: Sensor) -> "Block":
        """That of a sensor with a printed grid and a flat face."""
        design, rig = sensor.design, sensor.rig
        body, infill = design.materials.body, design.materials.infill
        assert infill is not None
        infilled = (1 - design.wall_mm / design.cell_mm) ** 3
        return cls(
            size_mm=(*design.footprint_mm, design.height_mm), lens_mm=rig.lens.thickness_mm,
            core_mm=(design.skin_mm, design.skin_mm + design.core_mm),
            scattering_per_mm=infilled * infill.sigma_s_per_mm,
            absorption_per_mm=infilled * infill.absorption_per_mm + (1 - infilled) * body.absorption_per_mm,
            ior=body.ior, reflectance=rig.strips[0].reflectance,
        )  # fmt: skip


def face_heights(sensor: Sensor, deformation: Deformation) -> Array:
    """How far the face is pressed in, shape (rows along y, columns along x), every `STEP_MM` [mm]."""
    nodes, width = sensor.printed.nodes_mm, sensor.design.footprint_mm
    top = nodes[:, 2] < FLAT_MM
    moved = nodes[top] + sensor.printed_displacements_mm(deformation)[top]
    axes = [np.arange(-edge / 2, edge / 2 + STEP_MM / 2, STEP_MM) for edge in width]
    found = griddata(moved[:, :2], moved[:, 2], tuple(np.meshgrid(*axes)), "linear", fill_value=0.0)
    return np.asarray(gaussian_filter(found, 1.0))


def touched_places(vertices_mm: Array, faces: npt.NDArray[np.int32], heights: Array) -> npt.NDArray[np.bool_]:
    """Which of those places touch the object: below the triangles of a contact."""
    mask = np.zeros(heights.shape, np.uint8)
    rows, columns = heights.shape
    corners = vertices_mm[faces][..., :2] / STEP_MM + ((columns - 1) / 2, (rows - 1) / 2)
    for each in np.round(corners).astype(np.int32):
        cv2.fillConvexPoly(mask, each, 1)
    return mask > 0


def touch_change(
    sensor: Sensor, state: FrameState, deformation: Deformation, *, particles: int, seed: int, albedo: float
) -> Array:
    """Relative change of the fluence of each cell by a touch, from just before contact, shape (cells, 3).

    Particles are those of each strip; the object sends back a diffuse share of the light, its albedo.
    """
    renderer, view, block = sensor.renderer, sensor.view(state, deformation), Block.of(sensor)
    contact = renderer.contact(renderer.placed(view))
    assert contact is not None
    heights = face_heights(sensor, deformation)
    touches = touched_places(contact.vertices, contact.faces, heights)
    counts = tuple(max(2, round(edge / BIN_MM)) for edge in block.size_mm)
    level, change = np.zeros((2, *counts[::-1], 3))
    for number, strip in enumerate(sensor.rig.strips):
        before, more = _follow(
            particles, seed + number, SIDES[strip.side], heights, touches, np.array(block.size_mm), block.lens_mm,
            np.array([*block.core_mm, strip.margin_mm]), block.scattering_per_mm, block.absorption_per_mm, block.ior,
            albedo, block.reflectance, np.array(counts),
        )  # fmt: skip
        level += before[..., None] * strip.radiance
        change += more[..., None] * strip.radiance
    axes = [(np.arange(count) + 0.5) / count * edge for count, edge in zip(counts, block.size_mm, strict=True)]
    axes = [axes[2], axes[1] - block.size_mm[1] / 2, axes[0] - block.size_mm[0] / 2]
    places = [renderer.light(each).inventory.centres_mm()[:, ::-1] for each in (View(), view)]
    rest, pressed = (
        RegularGridInterpolator(axes, values, bounds_error=False, fill_value=None)(where)
        for values, where in zip((level, level + change), places, strict=True)
    )
    return np.divide(pressed, rest, out=np.ones_like(rest), where=rest > 0) - 1


SIDES = {"-x": 0, "+x": 1, "-y": 2, "+y": 3}


@nb.njit(cache=True, inline="always")
def _random(stream):
    """The next number in 0..1 (Marsaglia's xorshift of 64 bits)."""
    stream[0] ^= stream[0] << np.uint64(13)
    stream[0] ^= stream[0] >> np.uint64(7)
    stream[0] ^= stream[0] << np.uint64(17)
    return (stream[0] >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@nb.njit(cache=True, inline="always")
def _reflected(cosine, ior):
    """Share of unpolarised light that the inner side of a face to air reflects (Fresnel)."""
    squared = ior * ior * (1 - cosine * cosine)
    if squared >= 1:
        return 1.0
    outer = np.sqrt(1 - squared)
    first = (ior * cosine - outer) / (ior * cosine + outer)
    second = (cosine - ior * outer) / (cosine + ior * outer)
    return 0.5 * (first * first + second * second)


@nb.njit(cache=True)
def _diffuse(way, normal, stream):
    """Turns a direction into one by Lambert's law about a normal."""
    first, turn = _random(stream), 2 * np.pi * _random(stream)
    radius, along = np.sqrt(first), np.sqrt(max(0.0, 1 - first))
    # An orthonormal frame about the normal (Duff and others 2017).
    sign = 1.0 if normal[2] >= 0 else -1.0
    a = -1 / (sign + normal[2])
    b = normal[0] * normal[1] * a
    u, v = radius * np.cos(turn), radius * np.sin(turn)
    x = u * (1 + sign * normal[0] * normal[0] * a) + v * b + along * normal[0]
    y = u * sign * b + v * (sign + normal[1] * normal[1] * a) + along * normal[1]
    z = -u * sign * normal[0] - v * normal[1] + along * normal[2]
    way[0], way[1], way[2] = x, y, z


@nb.njit(cache=True, inline="always")
def _height(heights, x, y):
    """Height of the face at a place, between those of the map."""
    rows, columns = heights.shape
    right, down = x / STEP_MM + (columns - 1) / 2, y / STEP_MM + (rows - 1) / 2
    column, row = min(max(int(right), 0), columns - 2), min(max(int(down), 0), rows - 2)
    right, down = right - column, down - row
    upper = heights[row, column] * (1 - right) + heights[row, column + 1] * right
    lower = heights[row + 1, column] * (1 - right) + heights[row + 1, column + 1] * right
    return upper * (1 - down) + lower * down


FREE, SIDE_X, SIDE_Y, LENS, FACE = range(5)


@nb.njit(cache=True)
def _reach(place, way, free, heights, most_mm, size, lens_mm, state):
    """How far a particle flies, and what it meets there."""
    length, meets = free, FREE
    for axis in range(2):
        if way[axis] != 0:
            side = (np.copysign(size[axis] / 2, way[axis]) - place[axis]) / way[axis]
            if side < length:
                length, meets = side, SIDE_X + axis
    if way[2] > 0:
        end = (size[2] + lens_mm - place[2]) / way[2]
        if end < length:
            length, meets = end, LENS
    elif state == UNTOUCHED and way[2] < 0:
        end = -place[2] / way[2]
        if end < length:
            length, meets = end, FACE
    if state == UNTOUCHED or (place[2] > most_mm and way[2] >= 0):
        return max(length, 0.0), meets
    along = 0.0
    if place[2] > most_mm:
        along = min((most_mm - place[2]) / way[2], length)
    above = place[2] + way[2] * along - _height(heights, place[0] + way[0] * along, place[1] + way[1] * along)
    while along < length:
        further = min(along + max(STEP_MM, 0.5 * above), length)
        x, y, z = place[0] + way[0] * further, place[1] + way[1] * further, place[2] + way[2] * further
        now = z - _height(heights, x, y)
        if now < 0:
            part = above / (above - now) if above > now and above > 0 else 0.0
            return max(along + part * (further - along) - 1e-4, 0.0), FACE
        if way[2] >= 0 and z > most_mm:
            break
        along, above = further, now
    return length, meets


@nb.njit(cache=True)
def _meets_dent(place, way, length, meets, heights, touches, most_mm, size, lens_mm):
    """Whether a flight through the untouched block is another one in the pressed block."""
    if min(place[2], place[2] + way[2] * length) > most_mm:
        return False
    other, met = _reach(place, way, length, heights, most_mm, size, lens_mm, DENTED)
    if met == FACE and other < length - 1e-3:
        return True
    if meets != FACE:
        return False
    x, y = place[0] + way[0] * length, place[1] + way[1] * length
    rows, columns = heights.shape
    column, row = int(x / STEP_MM + columns / 2), int(y / STEP_MM + rows / 2)
    column, row = min(max(column, 0), columns - 1), min(max(row, 0), rows - 1)
    return touches[row, column] or abs(heights[row, column]) > FLAT_MM


@nb.njit(cache=True)
def _count(place, way, length, weight, size, counts, found):
    """Adds a flight to the boxes that it passes, in steps of a half box at most."""
    steps = int(2 * length / BIN_MM) + 1
    step = length / steps
    for number in range(steps):
        along = (number + 0.5) * step
        x = int((place[0] + way[0] * along + size[0] / 2) * counts[0] / size[0])
        y = int((place[1] + way[1] * along + size[1] / 2) * counts[1] / size[1])
        z = int((place[2] + way[2] * along) * counts[2] / size[2])
        if 0 <= x < counts[0] and 0 <= y < counts[1] and 0 <= z < counts[2]:
            found[z, y, x] += weight * step


@nb.njit(cache=True)
def _walk(
    place, way, weight, stream, events, state, sign, heights, touches, most_mm, size, lens_mm, layers, scatters,
    absorbs, ior, albedo, reflectance, counts, found, more,
):  # fmt: skip
    """Follows a particle to its end. A scout, of sign 0, sends a pair on from where it meets the dent."""
    has_met = False
    while events < MOST_EVENTS and weight > 0:
        kept = stream[0]
        free = -np.log(1 - _random(stream)) / scatters if scatters > 0 else 1e9
        length, meets = _reach(place, way, free, heights, most_mm, size, lens_mm, state)
        if sign == 0 and not has_met and _meets_dent(
            place, way, length, meets, heights, touches, most_mm, size, lens_mm
        ):  # fmt: skip
            has_met = True  # the scout goes on, for the light of the untouched block
            for turn in range(2):
                own = stream.copy()
                own[0] = kept
                _walk(
                    place.copy(), way.copy(), weight, own, events, turn, 2 * turn - 1, heights, touches, most_mm, size,
                    lens_mm, layers, scatters, absorbs, ior, albedo, reflectance, counts, found, more,
                )  # fmt: skip
        middle = weight * np.exp(-0.5 * absorbs * length)
        if sign == 0:
            _count(place, way, length, middle, size, counts, found)
        else:
            _count(place, way, length, sign * middle, size, counts, more)
        weight *= np.exp(-absorbs * length)
        for axis in range(3):
            place[axis] += way[axis] * length
        weight = _turned(
            meets, place, way, weight, stream, state, heights, touches, size, layers, ior, albedo, reflectance
        )
        events += 1
        if weight < LEAST_WEIGHT:
            weight = 0.0 if _random(stream) < ENDS else weight / (1 - ENDS)


@nb.njit(cache=True)
def _turned(
    meets, place, way, weight, stream, state, heights, touches, size, layers, ior, albedo, reflectance,
):  # fmt: skip
    """Turns a particle where its flight ends; the weight that it keeps, 0 of one that is gone."""
    if meets == FREE:
        if layers[0] < place[2] < layers[1]:
            cosine, turn = 2 * _random(stream) - 1, 2 * np.pi * _random(stream)
            sine = np.sqrt(1 - cosine * cosine)
            way[0], way[1], way[2] = sine * np.cos(turn), sine * np.sin(turn), cosine
        return weight
    normal = np.zeros(3)
    if meets in (SIDE_X, SIDE_Y):
        if place[2] > size[2]:
            return 0.0  # out of the lens
        axis = meets - SIDE_X
        normal[axis] = -np.copysign(1.0, way[axis])
        _diffuse(way, normal, stream)
        place[axis] += 1e-3 * normal[axis]
        return weight * reflectance
    if meets == LENS:
        kept = _reflected(way[2], ior)
        way[2] = -way[2]
        place[2] -= 1e-3
        return weight * kept
    return _at_face(place, way, weight, stream, state, heights, touches, ior, albedo, normal)


@nb.njit(cache=True)
def _at_face(place, way, weight, stream, state, heights, touches, ior, albedo, normal):
    """Sends a particle back from the face; the weight that it keeps."""
    x, y = place[0], place[1]
    normal[0], normal[1], normal[2] = 0.0, 0.0, 1.0
    if state == DENTED:
        normal[0] = -(_height(heights, x + STEP_MM, y) - _height(heights, x - STEP_MM, y)) / (2 * STEP_MM)
        normal[1] = -(_height(heights, x, y + STEP_MM) - _height(heights, x, y - STEP_MM)) / (2 * STEP_MM)
        normal /= np.sqrt(normal[0] ** 2 + normal[1] ** 2 + 1)
        rows, columns = heights.shape
        column = min(max(int(x / STEP_MM + columns / 2), 0), columns - 1)
        row = min(max(int(y / STEP_MM + rows / 2), 0), rows - 1)
        if touches[row, column]:
            _diffuse(way, normal, stream)
            place += 2e-3 * normal
            return weight * albedo
    inward = min(way[0] * normal[0] + way[1] * normal[1] + way[2] * normal[2], -1e-3)
    way -= 2 * inward * normal
    place += 2e-3 * normal
    return weight * _reflected(-inward, ior)


@nb.njit(cache=True, parallel=True)
def _follow(
    particles, seed, side, heights, touches, size, lens_mm, layers, scatters, absorbs, ior, albedo, reflectance,
    counts,
):  # fmt: skip
    """Light of one strip in the untouched block, and what the dent changes, shape (boxes along z, y, x) each."""
    found = np.zeros((CHUNKS, counts[2], counts[1], counts[0]))
    more = np.zeros((CHUNKS, counts[2], counts[1], counts[0]))
    most_mm = heights.max() + 0.02
    axis, sign = side // 2, 1.0 if side % 2 == 0 else -1.0
    for chunk in nb.prange(CHUNKS):
        stream = np.zeros(1, np.uint64)
        place, way, normal = np.zeros(3), np.zeros(3), np.zeros(3)
        for number in range(chunk, particles, CHUNKS):
            stream[0] = np.uint64(88172645463325252) + np.uint64(1000003 * seed) + np.uint64(2654435761 * number)
            for _ in range(4):
                _random(stream)
            place[2] = layers[2] + (size[2] - 2 * layers[2]) * _random(stream)
            place[axis] = -sign * (size[axis] / 2 - 1e-3)
            place[1 - axis] = size[1 - axis] * (_random(stream) - 0.5)
            normal[:] = 0
            normal[axis] = sign
            _diffuse(way, normal, stream)
            weight = size[1 - axis] * (size[2] - 2 * layers[2])
            _walk(
                place, way, weight / (size[0] * size[1]), stream, 0, UNTOUCHED, 0, heights, touches, most_mm, size,
                lens_mm, layers, scatters, absorbs, ior, albedo, reflectance, counts, found[chunk], more[chunk],
            )  # fmt: skip
    return found.sum(0) / particles, more.sum(0) / particles
