"""Paths of light through a print at rest, from the camera back to what shines: one numba kernel.

The block is boxes alone, so that every next hit is exact: the outer box with the lens plate on it, the core, boxes of
the pitch in it, and in each of these a cell. Every choice is analog: reflection by Fresnel's formula, free ways between
scatterings; absorption is a weight. Radiance over the square of the index stays along a way, and so do the kinds of its
events when it is followed backwards.
"""

# ruff: noqa: PLR0912, PLR0915, PLR2004, NPY002 -- a kernel is one loop, and numba draws by itself.

import math

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.kernels import kernel

EVENTS = 5
"""Counted on a way: external and internal reflections at walls of cells, refractions there, scatterings, reflections at
outer faces."""
KINDS = 4
"""Kinds of reflections at walls on a way: none, external ones, internal ones, both."""
FAINT, KEPT = 0.05, 0.2
"""Weight below which a path goes on by chance, and that chance."""
MOST_STEPS = 2_000_000
"""Boxes that a path passes at most."""


@kernel(error_model="numpy")
def fresnel(cosine: float, before: float, after: float) -> float:
    """Share of unpolarised light that a smooth face reflects.

    Args:
        before: Refractive index where light comes from.
    """
    sine = before / after * math.sqrt(max(0.0, 1 - cosine * cosine))
    if sine >= 1:
        return 1.0
    beyond = math.sqrt(1 - sine * sine)
    across = (before * cosine - after * beyond) / (before * cosine + after * beyond)
    along = (after * cosine - before * beyond) / (after * cosine + before * beyond)
    return (across * across + along * along) / 2


@kernel(error_model="numpy")
def _leaving(place: Array, way: Array, low: Array, high: Array) -> tuple[float, int]:
    """Distance to where a ray leaves the box that it is in, and the axis of that face."""
    nearest, axis = np.inf, 0
    for a in range(3):
        if way[a] > 0:
            t = (high[a] - place[a]) / way[a]
        elif way[a] < 0:
            t = (low[a] - place[a]) / way[a]
        else:
            continue
        if t < nearest:
            nearest, axis = t, a
    return max(nearest, 0.0), axis


@kernel(error_model="numpy")
def _entering(place: Array, way: Array, low: Array, high: Array) -> tuple[float, int]:
    """Distance to where a ray enters a box that it is not in, infinite where it misses, and the axis of that face."""
    first, last, axis = -np.inf, np.inf, 0
    for a in range(3):
        if way[a] == 0:
            if place[a] <= low[a] or place[a] >= high[a]:
                return np.inf, 0
            continue
        near, far = (low[a] - place[a]) / way[a], (high[a] - place[a]) / way[a]
        if near > far:
            near, far = far, near
        if near > first:
            first, axis = near, a
        last = min(last, far)
    return (first, axis) if 0 < first < last else (np.inf, 0)


@kernel(error_model="numpy")
def _turned(way: Array, anisotropy: float) -> None:
    """A new direction by Henyey and Greenstein's function."""
    u = np.random.random()
    if abs(anisotropy) < 1e-6:
        cosine = 1 - 2 * u
    else:
        part = (1 - anisotropy * anisotropy) / (1 - anisotropy + 2 * anisotropy * u)
        cosine = (1 + anisotropy * anisotropy - part * part) / (2 * anisotropy)
    sine, angle = math.sqrt(max(0.0, 1 - cosine * cosine)), 2 * math.pi * np.random.random()
    x, y, z = way[0], way[1], way[2]
    if abs(z) > 0.99999:
        way[0], way[1], way[2] = sine * math.cos(angle), sine * math.sin(angle), math.copysign(cosine, z * cosine)
        return
    root = math.sqrt(1 - z * z)
    a, b = sine * math.cos(angle), sine * math.sin(angle)
    way[0] = x * cosine + (a * x * z - b * y) / root
    way[1] = y * cosine + (a * y * z + b * x) / root
    way[2] = z * cosine - a * root


@kernel(error_model="numpy")
def _kind(counts: Array) -> int:
    return (1 if counts[0] > 0 else 0) + (2 if counts[1] > 0 else 0)


@kernel(error_model="numpy")
def follow_paths(
    ways: Array, weights: Array, seed: int, low: Array, high: Array, origin: Array, pitch: Array, cell: Array,
    counts: Index, indices: Array, scattering: Array, absorption: Array, anisotropy: Array, strips: Array,
) -> tuple[Array, Array, float]:  # fmt: skip
    """Follows paths from the lens plate's outer face, inside, until they end.

    Args:
        ways: Directions at the start, inside of the plate, shape (paths, 2, 3): places [mm], then directions.
        weights: At the start, shape (paths,).
        low: Corner of the outer box, shape (3,) [mm].
        high: The other corner, shape (3,) [mm].
        origin: Corner of the core, shape (3,) [mm].
        pitch: Shape (3,) [mm].
        cell: Edges of a cell, shape (3,) [mm].
        counts: Cells along each axis, shape (3,).
        scattering: Coefficients of body and infill [1/mm].
        absorption: Likewise [1/mm].
        strips: One row each: axis, sign of its side, plane [mm], half width along the side [mm], lowest and highest z
            [mm], reflectance.

    Returns:
        Weight that reaches what shines, shape (strips + 1, KINDS, KINDS), the last one the room below the contact face:
        by the kinds of reflections on the whole way, and on its last leg, from the last scattering to the camera. Sums
        of weight times events, shape (strips + 1, EVENTS). Weight that was given up.
    """
    np.random.seed(seed)
    lights = len(strips) + 1
    found, events, lost = np.zeros((lights, KINDS, KINDS)), np.zeros((lights, EVENTS)), 0.0
    core_high = origin + pitch * counts
    place, way, number = np.zeros(3), np.zeros(3), np.zeros(3, np.int64)
    box_low, box_high, cell_low, cell_high = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    seen = np.zeros(EVENTS)
    for path in range(len(ways)):
        place[:], way[:], weight = ways[path, 0], ways[path, 1], weights[path]
        seen[:] = 0
        in_cell, in_core, leg = False, False, -1
        for step in range(MOST_STEPS):
            if step == MOST_STEPS - 1:
                lost += weight
            if weight < FAINT * weights[path]:
                if np.random.random() >= KEPT:
                    break
                weight /= KEPT
            medium = 1 if in_cell else 0
            light, light_t, t_in, axis_in = -1, np.inf, np.inf, 0
            if in_core:
                for a in range(3):
                    box_low[a] = origin[a] + number[a] * pitch[a]
                    box_high[a] = box_low[a] + pitch[a]
                    cell_low[a] = box_low[a] + (pitch[a] - cell[a]) / 2
                    cell_high[a] = cell_low[a] + cell[a]
                if in_cell:
                    t, axis = _leaving(place, way, cell_low, cell_high)
                else:
                    t, axis = _leaving(place, way, box_low, box_high)
                    t_in, axis_in = _entering(place, way, cell_low, cell_high)
            else:
                t, axis = _leaving(place, way, low, high)
                t_in, axis_in = _entering(place, way, origin, core_high)
                for k in range(len(strips)):
                    a, b = int(strips[k, 0]), 1 - int(strips[k, 0])
                    if way[a] == 0:
                        continue
                    t_strip = (strips[k, 2] - place[a]) / way[a]
                    if 1e-9 < t_strip < light_t:
                        z = place[2] + t_strip * way[2]
                        if abs(place[b] + t_strip * way[b]) <= strips[k, 3] and strips[k, 4] <= z <= strips[k, 5]:
                            light, light_t = k, t_strip
            nearest = min(t, t_in, light_t)
            if scattering[medium] > 0:
                free = -math.log(1 - np.random.random()) / scattering[medium]
                if free < nearest:
                    place += free * way
                    weight *= math.exp(-absorption[medium] * free)
                    _turned(way, anisotropy[medium])
                    seen[3] += 1
                    if leg < 0:
                        leg = _kind(seen)
                    continue
            place += nearest * way
            weight *= math.exp(-absorption[medium] * nearest)
            if nearest == light_t:
                a = int(strips[light, 0])
                if way[a] * strips[light, 1] <= 0:  # the strip's back
                    break
                found[light, _kind(seen), _kind(seen) if leg < 0 else leg] += weight
                events[light] += weight * seen
                weight *= strips[light, 6]
                if weight == 0:
                    break
                if leg < 0:
                    leg = _kind(seen)
                radius, angle = math.sqrt(np.random.random()), 2 * math.pi * np.random.random()
                way[a] = -strips[light, 1] * math.sqrt(1 - radius * radius)
                way[1 - a], way[2] = radius * math.cos(angle), radius * math.sin(angle)
                continue
            if in_core and not in_cell and t <= t_in:  # the next box of the core, or out of it
                place[axis] = box_high[axis] if way[axis] > 0 else box_low[axis]
                number[axis] += 1 if way[axis] > 0 else -1
                in_core = 0 <= number[axis] < counts[axis]
                continue
            if not in_core and t_in < t:
                in_core = True
                place[axis_in] = origin[axis_in] if way[axis_in] > 0 else core_high[axis_in]
                for a in range(3):
                    index = math.floor((place[a] - origin[a]) / pitch[a])
                    number[a] = min(max(index, 0), counts[a] - 1)
                number[axis_in] = 0 if way[axis_in] > 0 else counts[axis_in] - 1
                continue
            # An interface.
            is_outer = not in_core
            if in_core and not in_cell:
                axis = axis_in
                place[axis] = cell_low[axis] if way[axis] > 0 else cell_high[axis]
            elif in_cell:
                place[axis] = cell_high[axis] if way[axis] > 0 else cell_low[axis]
            else:
                place[axis] = high[axis] if way[axis] > 0 else low[axis]
            before = indices[medium]
            after = 1.0 if is_outer else indices[1 - medium]
            if np.random.random() < fresnel(abs(way[axis]), before, after):
                way[axis] = -way[axis]
                if is_outer:
                    seen[4] += 1
                elif before < after:
                    seen[0] += 1
                else:
                    seen[1] += 1
                continue
            if is_outer:
                if axis == 2 and way[2] < 0:
                    found[lights - 1, _kind(seen), _kind(seen) if leg < 0 else leg] += weight
                    events[lights - 1] += weight * seen
                break
            seen[2] += 1
            for a in range(3):
                if a != axis:
                    way[a] *= before / after
            others = 1.0
            for a in range(3):
                if a != axis:
                    others -= way[a] * way[a]
            way[axis] = math.copysign(math.sqrt(max(others, 0.0)), way[axis])
            in_cell = not in_cell
    return found, events, lost
