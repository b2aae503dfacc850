"""Printed walls as structural springs: what they add to the lattice where a cell is stiffer along its walls.

A core cell is cubic, not isotropic: its walls carry load along x, y and z better than across. The network springs have
no rest length and cannot hold that (their affine energy is mu/2 tr(F^T F) whatever their weights), so the cell's edges
carry springs that have one, four along each axis, with the energy per volume

    beta sum_k f(I_k),   I_k = |F e_k|^2 = (length / rest length)^2,   f -> eps_kk^2 for small strain.

They add 2 beta to C11 and nothing to C12 and C44, so mu = C44 and beta = (C11 - C12)/2 - C44. The law is the
neo-Hookean fibre

    f = (I - 1 - ln I) / 2,

the only function of I with which a cell squeezed or stretched along its walls is neo-Hookean with the modulus
(C11 - C12)/2, as the periodic cell of neo-Hookean walls and infill is to 1 % up to 50 % strain. A compressed wall tilts
away: a state stays elliptic only while mu + 2 beta f' > 0, and the cell itself buckles where that vanishes. So f' is
bounded from below by -(a + r), a = 0.7 rho, r = 0.2 rho, rho = mu / 2 beta: from I_s = 1 / (1 + 2 a) downwards it
relaxes exponentially towards that bound, twice differentiable, and a tenth of mu always remains.
"""

# ruff: noqa: ANN001, ANN201 -- numba infers the types of the kernels.

import numpy as np

from magicsim.kernels import kernel

FOLLOWED, RELAXED = 0.7, 0.2
"""Parts of rho = mu / 2 beta down to which -f' is followed, and by which it may still grow."""


@kernel(error_model="numpy")
def wall_energy(square: float, rho: float) -> tuple[float, float, float]:
    """The law f of the squared stretch, bounded by rho = mu / 2 beta: value, first and second derivative."""
    a, r = FOLLOWED * rho, RELAXED * rho
    start = 1 / (1 + 2 * a)
    if square >= start:
        return (square - 1 - np.log(square)) / 2, (1 - 1 / square) / 2, 0.5 / (square * square)
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
        across, along = 2 * stiffness * first * unit, 4 * stiffness * second * unit * unit
        for i in range(3):
            for k in range(3):
                entry = along * d[i] * d[k] + (across if i == k else 0.0)
                own[3 * p + i, 3 * p + k] += entry
                own[3 * r + i, 3 * r + k] += entry
                own[3 * p + i, 3 * r + k] -= entry
                own[3 * r + i, 3 * p + k] -= entry
