"""Energy, forces and stiffness of single cells: numba kernels over all of them.

With M the gradient of the trilinear map from the unit cube at a Gauss point, J = det M / 8w for a point of rest volume
w, and the derivative of its deformed volume w J by the corners is cof(M) / 8 times the gradients on the unit cube: the
shape of the cell at rest enters by w alone. Each column of M is a mean of the four edges along it, and is shared by the
two points that lie behind each other; forces are handed back to the corners along the same edges.

**Walls.** A core cell is cubic, not isotropic: its walls carry load along x, y and z better than across. The network
springs have no rest length and cannot hold that (their affine energy is mu/2 tr(F^T F) whatever their weights), so the
cell's edges carry springs that have one, four along each axis, with the energy per volume

    beta sum_k f(I_k),   I_k = |F e_k|^2 = (length / rest length)^2,   f -> eps_kk^2 for small strain.

They add 2 beta to C11 and nothing to C12 and C44. The law is the neo-Hookean fibre f = (I - 1 - ln I) / 2, the only
function of I with which a cell squeezed or stretched along its walls is neo-Hookean with the modulus (C11 - C12)/2, as
the periodic cell of neo-Hookean walls and infill is to 1 % up to 50 % strain. A compressed wall tilts away: a state
stays elliptic only while mu + 2 beta f' > 0, and the cell itself buckles where that vanishes. So f' is bounded from
below by -(a + r), a = 0.7 rho, r = 0.2 rho, rho = mu / 2 beta: from I_s = 1 / (1 + 2 a) downwards it relaxes
exponentially towards that bound, twice differentiable, and a tenth of mu always remains.
"""

# ruff: noqa: ANN001, ANN201, ANN202, PLR0912 -- numba infers the types of the kernels.

import numpy as np

from magicsim.deform.lattice.hexahedron import (
    CORNERS_ALONG,
    EDGES,
    GAUSS_COLUMNS,
    GAUSS_GRADIENTS,
    MEAN_OF_EDGES,
    NEXT_CORNER,
)
from magicsim.kernels import kernel

FOLLOWED, RELAXED = 0.7, 0.2
"""Parts of rho = mu / 2 beta down to which -f' is followed, and by which it may still grow. Assumed: any two whose sum
is below 1 leave a stable cell."""
LOG_LIMIT = 0.01
"""Jacobian below which -ln J is continued as a parabola. Assumed: only trial states are squeezed so far."""
PAIRS = np.array([[p, r] for p in range(8) for r in range(p + 1, 8)])
"""Pairs of corners, shape (28, 2)."""
CROSSED = np.cross(GAUSS_GRADIENTS[:, PAIRS[:, 0]], GAUSS_GRADIENTS[:, PAIRS[:, 1]]).transpose(0, 2, 1).reshape(24, -1)
"""Cross products of the gradients of pairs of corners on the unit cube, shape (8 points x 3, 28)."""
GRADIENTS = np.ascontiguousarray(GAUSS_GRADIENTS)


@kernel(error_model="numpy")
def wall_energy(square: float, rho: float) -> tuple[float, float, float]:
    """The law f of the squared stretch, bounded by rho = mu / 2 beta: value, first and second derivative."""
    a, r = FOLLOWED * rho, RELAXED * rho
    start = 1 / (1 + 2 * a)
    # the neo-Hookean fibre, f = (I - 1 - ln I) / 2, down to where -f' = a
    if square >= start:
        return (square - 1 - np.log(square)) / 2, (1 - 1 / square) / 2, 0.5 / (square * square)
    # -f' goes from a to a + r exponentially, at the rate that continues the fibre's own curvature
    curvature = 0.5 / (start * start)
    length = r / curvature
    d = start - square
    decay = np.exp(-d / length)
    value = (start - 1 - np.log(start)) / 2 + a * d + r * (d - length * (1 - decay))
    return value, -a - r * (1 - decay), curvature * decay


@kernel(error_model="numpy")
def add_walls(x, nodes, edges, lengths, stiffness, rho, own):  # type: ignore[no-untyped-def]
    """Adds the forces of a cell's edges to `own`, shape (8, 3) [N]; returns their energy [N mm].

    `stiffness` is beta V / 4 [N mm], `rho` is mu / 2 beta, `lengths` are the edges at rest, shape (12,) [mm].
    """
    total = 0.0
    for e in range(edges.shape[0]):
        p, r = edges[e, 0], edges[e, 1]
        unit = 1 / (lengths[e] * lengths[e])
        square = 0.0
        for i in range(3):
            d = x[nodes[r], i] - x[nodes[p], i]
            square += d * d * unit
        value, first, _ = wall_energy(square, rho)
        total += stiffness * value
        # the squared stretch I = |d|^2 / L^2 has the gradient 2 d / L^2 at one end, and its opposite at the other
        for i in range(3):
            force = 2 * stiffness * first * unit * (x[nodes[r], i] - x[nodes[p], i])
            own[r, i] += force
            own[p, i] -= force
    return total


@kernel(error_model="numpy")
def add_wall_stiffness(x, nodes, edges, lengths, stiffness, rho, own):  # type: ignore[no-untyped-def]
    """Adds the edges' Hessian to `own`, shape (24, 24) [N/mm]."""
    d = np.empty(3)
    for e in range(edges.shape[0]):
        p, r = edges[e, 0], edges[e, 1]
        unit = 1 / (lengths[e] * lengths[e])
        square = 0.0
        for i in range(3):
            d[i] = x[nodes[r], i] - x[nodes[p], i]
            square += d[i] * d[i] * unit
        _, first, second = wall_energy(square, rho)
        # f' times the second derivative of I, alike in all directions, and f'' times its gradient 2 d / L^2 squared
        across, along = 2 * stiffness * first * unit, 4 * stiffness * second * unit * unit
        for i in range(3):
            for k in range(3):
                entry = along * d[i] * d[k] + (across if i == k else 0.0)
                own[3 * p + i, 3 * p + k] += entry
                own[3 * r + i, 3 * r + k] += entry
                own[3 * p + i, 3 * r + k] -= entry
                own[3 * r + i, 3 * p + k] -= entry


@kernel(error_model="numpy")
def negative_log(jacobian: float) -> tuple[float, float, float]:
    """-ln J, twice continuously differentiable down to any J: value, first and second derivative."""
    if jacobian > LOG_LIMIT:
        return -np.log(jacobian), -1 / jacobian, 1 / (jacobian * jacobian)
    # the parabola's curvature would be finite
    if np.isnan(jacobian):
        return np.nan, np.nan, np.nan
    # value, slope and curvature of the logarithm go on: a Newton step that folds a cell still has a way back
    d = jacobian - LOG_LIMIT
    slope, curvature = 1 / LOG_LIMIT, 1 / LOG_LIMIT**2
    return -np.log(LOG_LIMIT) - slope * d + curvature / 2 * d * d, -slope + curvature * d, curvature


@kernel(error_model="numpy")
def _columns(x, nodes, place, edge, columns):  # type: ignore[no-untyped-def]
    """The corners' places, shape (8, 3), and the columns of M, shape (3 directions, 4, 3), in place."""
    for p in range(8):
        for i in range(3):
            place[p, i] = x[nodes[p], i]
    for d in range(3):
        for m in range(4):
            first = CORNERS_ALONG[d, m]
            for i in range(3):
                edge[m, i] = place[first + NEXT_CORNER[d], i] - place[first, i]
        # the map is trilinear: its derivative along an edge is a mean of the four parallel edges, by how near they are
        for s in range(4):
            for i in range(3):
                total = 0.0
                for m in range(4):
                    total += MEAN_OF_EDGES[s, m] * edge[m, i]
                columns[d, s, i] = total


@kernel(error_model="numpy")
def _cofactor(a, b, c, cof):  # type: ignore[no-untyped-def]
    """Columns of cof(M) / 8 from those of M, in place; returns det M / 8."""
    # each column is the cross product of the two others, the derivative of det M by the column itself; the eighth is
    # that of the unit cube's volume for which a Gauss point stands
    for i in range(3):
        k, n = (i + 1) % 3, (i + 2) % 3
        cof[0, i] = (b[k] * c[n] - b[n] * c[k]) / 8
        cof[1, i] = (c[k] * a[n] - c[n] * a[k]) / 8
        cof[2, i] = (a[k] * b[n] - a[n] * b[k]) / 8
    return a[0] * cof[0, 0] + a[1] * cof[0, 1] + a[2] * cof[0, 2]


@kernel(error_model="numpy", nogil=True)
def evaluate_cells(  # type: ignore[no-untyped-def]
    x, cells, weights, mu, lame, springs, walls, rho, lengths, energy, jacobian, volume_gradient, gradient
):
    """Writes energy, mean Jacobian and gradient of the volume of each cell, and adds up their forces.

    Arguments are those of `Elasticity`, results those of `ElasticState`; returns the smallest Jacobian.
    """
    smallest = np.inf
    place, edge, own, cof = np.empty((8, 3)), np.empty((4, 3)), np.empty((8, 3)), np.empty((3, 3))
    columns, bulk, log = np.empty((3, 4, 3)), np.empty((3, 4, 3)), np.empty((3, 4, 3))
    for c in range(cells.shape[0]):
        nodes = cells[c]
        _columns(x, nodes, place, edge, columns)
        mean, total, volume = 0.0, 0.0, 0.0
        # springs without rest length: forces are the Laplacian times the places, the energy half of their product
        for p in range(8):
            fx, fy, fz = 0.0, 0.0, 0.0
            for r in range(8):
                k = springs[c, p, r]
                fx += k * place[r, 0]
                fy += k * place[r, 1]
                fz += k * place[r, 2]
            own[p, 0], own[p, 1], own[p, 2] = fx, fy, fz
            total += 0.5 * (fx * place[p, 0] + fy * place[p, 1] + fz * place[p, 2])
        # cof(M) / 8 of a Gauss point counts for its columns: two points that lie behind each other share one
        bulk[:], log[:] = 0.0, 0.0
        for q in range(8):
            s0, s1, s2 = GAUSS_COLUMNS[q, 0], GAUSS_COLUMNS[q, 1], GAUSS_COLUMNS[q, 2]
            weight = weights[c, q]
            deformed = _cofactor(columns[0, s0], columns[1, s1], columns[2, s2], cof)
            j = deformed / weight
            # so written, it also takes over NaN
            if not j >= smallest:
                smallest = j
            value, first, _ = negative_log(j)
            volume += weight
            mean += deformed
            # the springs hold 3/2 mu for each volume at rest, where the energy is to be zero
            total += mu[c] * weight * (value - 1.5)
            stress = mu[c] * first
            for i in range(3):
                bulk[0, s0, i] += cof[0, i]
                bulk[1, s1, i] += cof[1, i]
                bulk[2, s2, i] += cof[2, i]
                log[0, s0, i] += stress * cof[0, i]
                log[1, s1, i] += stress * cof[1, i]
                log[2, s2, i] += stress * cof[2, i]
        # columns are means of edges, so what is due to a column goes to both ends of its edges by the same weights
        volume_gradient[c] = 0.0
        for d in range(3):
            for m in range(4):
                a = CORNERS_ALONG[d, m]
                b = a + NEXT_CORNER[d]
                for i in range(3):
                    of_bulk, of_log = 0.0, 0.0
                    for s in range(4):
                        of_bulk += MEAN_OF_EDGES[s, m] * bulk[d, s, i]
                        of_log += MEAN_OF_EDGES[s, m] * log[d, s, i]
                    volume_gradient[c, 3 * a + i] -= of_bulk
                    volume_gradient[c, 3 * b + i] += of_bulk
                    own[a, i] -= of_log
                    own[b, i] += of_log
        if walls[c] > 0:
            total += add_walls(x, nodes, EDGES, lengths[c], walls[c], rho[c], own)
        energy[c], jacobian[c] = total, mean / volume
        # the gradient of lambda/2 V (Jbar - 1)^2; its energy is left to the caller, who may take another pressure
        pressure = lame[c] * (mean / volume - 1)
        for p in range(8):
            for i in range(3):
                gradient[nodes[p], i] += own[p, i] + pressure * volume_gradient[c, 3 * p + i]
    return smallest


@kernel(error_model="numpy", nogil=True)
def add_stiffness(  # type: ignore[no-untyped-def]
    x, cells, weights, mu, stiffness, pressure, springs, walls, rho, lengths, volume_gradient, indptr, blocks, values
):
    """Adds the Hessian of every cell to the entries of an upper triangle, see `BlockPattern`, in place."""
    place, edge, columns, cof = np.empty((8, 3)), np.empty((4, 3)), np.empty((3, 4, 3)), np.empty((3, 3))
    right, left, own = np.empty((9, 24)), np.empty((9, 24)), np.empty((24, 24))
    geometric, turned = np.empty((3, 24)), np.empty((3, 28))
    for c in range(cells.shape[0]):
        nodes = cells[c]
        _columns(x, nodes, place, edge, columns)
        for q in range(8):
            a, b, d = columns[0, GAUSS_COLUMNS[q, 0]], columns[1, GAUSS_COLUMNS[q, 1]], columns[2, GAUSS_COLUMNS[q, 2]]
            deformed = _cofactor(a, b, d, cof)
            _, first, second = negative_log(deformed / weights[c, q])
            # the Hessian of -mu w ln J: an outer product of J', cof(M) / 8w times the corners' gradients, and that of J
            outer = mu[c] * second / weights[c, q]
            for p in range(8):
                for i in range(3):
                    slope = 0.0
                    for k in range(3):
                        slope += cof[k, i] * GRADIENTS[q, p, k]
                    right[q, 3 * p + i], left[q, 3 * p + i] = slope, outer * slope
            # the logarithm's stress and the cell's pressure multiply the second derivative of the deformed volume
            stress = (mu[c] * first + pressure[c]) / 8
            for i in range(3):
                geometric[i, 3 * q] = stress * a[i]
                geometric[i, 3 * q + 1] = stress * b[i]
                geometric[i, 3 * q + 2] = stress * d[i]
        # the bulk stiffness lambda / V of the whole cell is one more outer product
        for k in range(24):
            right[8, k], left[8, k] = volume_gradient[c, k], stiffness[c] * volume_gradient[c, k]
        # all outer products at once, and all second derivatives of the volume: by the corners p and r that of det M is
        # the cross product with M (g_p x g_r), a skew block, g being the corners' gradients on the unit cube
        np.dot(left.T, right, own)
        np.dot(geometric, CROSSED, turned)
        for p in range(8):
            for r in range(8):
                for i in range(3):
                    own[3 * p + i, 3 * r + i] += springs[c, p, r]
        if walls[c] > 0:
            add_wall_stiffness(x, nodes, EDGES, lengths[c], walls[c], rho[c], own)
        # a corner by itself has none: det M is linear in the place of each corner
        for k in range(28):
            p, r = 3 * PAIRS[k, 0], 3 * PAIRS[k, 1]
            own[p, r + 1] += turned[2, k]
            own[p + 1, r] -= turned[2, k]
            own[p + 1, r + 2] += turned[0, k]
            own[p + 2, r + 1] -= turned[0, k]
            own[p + 2, r] += turned[1, k]
            own[p, r + 2] -= turned[1, k]
        for p in range(8):
            for r in range(p, 8):
                # negative where a corner is bonded
                block = blocks[c, p, r]
                if block < 0:
                    continue
                for i in range(3):
                    # row i of a diagonal block has lost its first i entries, see `block_pattern`
                    start = indptr[3 * nodes[p] + i] + 3 * block - i
                    for k in range(i if p == r else 0, 3):
                        values[start + k] += own[3 * p + i, 3 * r + k]
