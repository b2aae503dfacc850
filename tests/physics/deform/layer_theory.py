"""Frictionless contact of a rigid body of revolution with an elastic layer, by linear theory.

A pressure with the Hankel transform p(xi) = integral_0^a f(t) cos(xi t) dt vanishes outside the contact radius a.
The layer of thickness h, bonded below, answers with the surface displacement (2/E*) int L(xi h) p(xi) J0(xi r) d xi,

    L(x) = (2 k sinh 2x - 4x) / (2 k cosh 2x + 4x^2 + 1 + k^2),  k = 3 - 4 nu

and resting on a smooth plane that it does not leave with L(x) = (cosh 2x - 1) / (sinh 2x + 2x)

(Hayes, Keer, Herrmann and Mockros, J. Biomech. 5, 1972; Vorovich, Aleksandrov and Babeshko 1974). Abel's inversion of
"displacement = depth - shape" for r < a leaves a Fredholm equation of the second kind for f,

    f(t) - (1/pi) int_0^a [M(t + s) + M(t - s)] f(s) ds = (E*/pi) (depth - g(t))
    M(x) = (1/h) int (1 - L(u)) cos(u x / h) du

with g(t) = d/dt int_0^t r shape(r) / sqrt(t^2 - r^2) dr, and F = 2 pi int_0^a f dt. It is the half-space for h -> inf.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import roots_legendre

Array = npt.NDArray[np.float64]
WAVENUMBERS = roots_legendre(1500)
LARGEST_WAVENUMBER = 24.0
"""In units of 1/h; 1 - L has decayed to 1e-17 there."""
RADII = roots_legendre(120)


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """Equilibrium with a contact radius."""

    depth_mm: float
    force_n: float


def sphere(radius_mm: float) -> Callable[[Array], Array]:
    """Function g of a paraboloid r^2 / 2R."""
    return lambda t: t**2 / radius_mm


def cone(half_angle_deg: float) -> Callable[[Array], Array]:
    """Function g of a cone r / tan(alpha), alpha measured from the axis."""
    return lambda t: np.pi / 2 * t / np.tan(np.radians(half_angle_deg))


def layer_contact(
    shape: Callable[[Array], Array] | None, contact_mm: float, *, height_mm: float, modulus_mpa: float, poisson: float,
    is_bonded: bool = True,
) -> Contact:  # fmt: skip
    """Depth and force at a contact radius.

    Args:
        shape: g of the object; None is a flat punch pressed by 1 mm.
        contact_mm: Contact radius a, up to about 50 heights [mm].
        height_mm: Thickness h [mm].
        modulus_mpa: E* = E / (1 - nu^2) [MPa].
        poisson: nu.
        is_bonded: Whether the layer is bonded to its base; smooth otherwise.
    """
    nodes, weights = (RADII[0] + 1) / 2, RADII[1] / 2
    u, du = (WAVENUMBERS[0] + 1) / 2 * LARGEST_WAVENUMBER, WAVENUMBERS[1] / 2 * LARGEST_WAVENUMBER
    k = 3 - 4 * poisson
    rest = 1 - (2 * k * np.sinh(2 * u) - 4 * u) / (2 * k * np.cosh(2 * u) + 4 * u**2 + 1 + k**2)
    if not is_bonded:
        rest = 1 - (np.cosh(2 * u) - 1) / (np.sinh(2 * u) + 2 * u)
    t, ds = contact_mm * np.append(nodes, 1.0), contact_mm * np.append(weights, 0.0)
    # cos u(t + s) + cos u(t - s) = 2 cos ut cos us
    wave = np.cos(np.outer(t, u) / height_mm)
    kernel = 2 * (wave * (rest * du)) @ wave.T / height_mm
    system = np.eye(len(t)) - kernel * ds / np.pi
    unit = np.linalg.solve(system, np.full(len(t), modulus_mpa / np.pi))
    if shape is None:
        return Contact(depth_mm=1.0, force_n=float(2 * np.pi * ds @ unit))
    form = np.linalg.solve(system, modulus_mpa / np.pi * shape(t))
    depth = form[-1] / unit[-1]
    return Contact(depth_mm=float(depth), force_n=float(2 * np.pi * ds @ (depth * unit - form)))
