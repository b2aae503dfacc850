"""Sphere on a bonded block: the lattice against an independent finite-element solution.

    python benchmarks/sphere_on_block.py                 # needs the extra `reference` (NGSolve)
    python benchmarks/sphere_on_block.py --elements 0.4  # one mesh, elements of 0.4 mm under the sphere

The problem: `uniform-block` (24 x 32 x 6 mm, E = 0.9933 MPa, nu = 0.49), bonded at z = height, pressed by a rigid
frictionless sphere of radius 4 mm. The solid is W = mu/2 (I1 - 3) - mu ln J + lambda/2 (J - 1)^2. The reference
shares no code with the package: a quarter of the block by symmetry, tetrahedra with quadratic displacements (no
averaging of the volume, no pressure unknown), contact by a penalty at its own quadrature points, extrapolated from
two stiffnesses to a rigid contact. The exact contact condition is used: the deformed point's distance to the
sphere's centre.
"""

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import ngsolve as ngs
from netgen.occ import Box, Glue, OCCGeometry, Pnt

from magicsim.config import load_preset
from magicsim.deform.press import press
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects import parse_object

YOUNGS_MODULUS_MPA, POISSON_RATIO = 0.9933, 0.49
HALF_X_MM, HALF_Y_MM, HEIGHT_MM, RADIUS_MM = 12.0, 16.0, 6.0, 4.0
FINE_MM, FINE_DEPTH_MM = 2.8, 1.5
PENALTIES = (150.0, 600.0)
"""Contact stiffness [N/mm3]; the remaining error is inversely proportional to it."""

SOFT_PENALTY = 15.0
"""Stiffness of the first solve at each depth, which the stiffer ones start from [N/mm3]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceForce:
    """The reference at one depth."""

    depth_mm: float
    force_n: float
    """Extrapolated to a rigid contact."""
    soft_force_n: float
    """With the stiffer penalty, before extrapolation."""
    contact_area_mm2: float
    """Deformed area inside the sphere with the stiffer penalty."""
    element_mm: float
    order: int
    unknowns: int
    seconds: float


def reference_forces(depths_mm: Sequence[float], *, element_mm: float, order: int = 2) -> list[ReferenceForce]:
    """Solves the quarter block.

    Args:
        depths_mm: Increasing depths [mm].
        element_mm: Element size under the sphere [mm]; four times that far away.
        order: Polynomial degree of the displacement.
    """
    start = time.perf_counter()
    mesh = _mesh(element_mm)
    space = ngs.VectorH1(
        mesh, order=order, dirichletx="bonded|plane_x", dirichlety="bonded|plane_y", dirichletz="bonded"
    )
    depth, penalty = ngs.Parameter(0.0), ngs.Parameter(PENALTIES[0])
    energy, pressure, touching_area = _energy(space, depth, penalty)
    state = ngs.GridFunction(space)
    results = []
    for target in depths_mm:
        steps = max(1, round((target - depth.Get()) / 0.1))
        for value in [depth.Get() + (target - depth.Get()) * (i + 1) / steps for i in range(steps)]:
            depth.Set(value)
            for stiffness in (SOFT_PENALTY, PENALTIES[0]):
                penalty.Set(stiffness)
                _newton(energy, state)
        forces = []
        for value in PENALTIES:
            penalty.Set(value)
            _newton(energy, state)
            forces.append(4 * ngs.Integrate(pressure(state) * ngs.ds("contact", bonus_intorder=6), mesh))
        rigid = forces[1] + (forces[1] - forces[0]) * PENALTIES[0] / (PENALTIES[1] - PENALTIES[0])
        results.append(
            ReferenceForce(
                depth_mm=target, force_n=rigid, soft_force_n=forces[1],
                contact_area_mm2=4 * ngs.Integrate(touching_area(state) * ngs.ds("contact", bonus_intorder=6), mesh),
                element_mm=element_mm, order=order,
                unknowns=sum(space.FreeDofs()), seconds=time.perf_counter() - start,
            )
        )  # fmt: skip
    return results


def _mesh(element_mm: float) -> ngs.Mesh:
    block = Box(Pnt(0, 0, 0), Pnt(HALF_X_MM, HALF_Y_MM, HEIGHT_MM))
    fine = Box(Pnt(0, 0, 0), Pnt(FINE_MM, FINE_MM, FINE_DEPTH_MM))
    fine.maxh = element_mm
    solid = Glue([block - fine, fine])
    for face in solid.faces:
        face.name = "free"
    for name, faces in {
        "plane_x": [face for face in solid.faces if abs(face.center.x) < 1e-6],
        "plane_y": [face for face in solid.faces if abs(face.center.y) < 1e-6],
        "contact": [face for face in solid.faces if abs(face.center.z) < 1e-6],
        "bonded": [face for face in solid.faces if abs(face.center.z - HEIGHT_MM) < 1e-6],
    }.items():
        for face in faces:
            face.name = name
    return ngs.Mesh(OCCGeometry(solid).GenerateMesh(maxh=4 * element_mm, grading=0.35))


def _energy(space, depth, penalty):  # noqa: ANN001, ANN202
    mu = YOUNGS_MODULUS_MPA / (2 * (1 + POISSON_RATIO))
    lame = 2 * mu * POISSON_RATIO / (1 - 2 * POISSON_RATIO)
    u = space.TrialFunction()
    gradient = ngs.Id(3) + ngs.Grad(u)
    jacobian = ngs.Det(gradient)
    solid = mu / 2 * (ngs.InnerProduct(gradient, gradient) - 3) - mu * ngs.log(jacobian)
    solid += lame / 2 * (jacobian - 1) ** 2

    def overlap(displacement):  # noqa: ANN001, ANN202
        point = ngs.CF((ngs.x, ngs.y, ngs.z)) + displacement
        offset = point - ngs.CF((0, 0, depth - RADIUS_MM))
        length = ngs.sqrt(ngs.InnerProduct(offset, offset))
        return ngs.IfPos(RADIUS_MM - length, RADIUS_MM - length, 0), offset[2] / length

    form = ngs.BilinearForm(space, symmetric=True)
    form += ngs.Variation(solid * ngs.dx)
    form += ngs.Variation(penalty / 2 * overlap(u)[0] ** 2 * ngs.ds("contact", bonus_intorder=6))

    def pressure(state):  # noqa: ANN001, ANN202
        depth_inside, upward = overlap(state)
        return penalty * depth_inside * upward

    def touching_area(state):  # noqa: ANN001, ANN202
        deformed = ngs.Id(3) + ngs.Grad(state)
        stretched = ngs.Cof(deformed) * ngs.specialcf.normal(3)
        return ngs.IfPos(overlap(state)[0], ngs.Norm(stretched), 0)

    return form, pressure, touching_area


def _newton(form, state, tolerance: float = 1e-8) -> None:  # noqa: ANN001
    """Newton with halved steps until the energy falls."""
    residual, step = state.vec.CreateVector(), state.vec.CreateVector()
    trial = state.vec.CreateVector()
    for _ in range(100):
        form.Apply(state.vec, residual)
        form.AssembleLinearization(state.vec)
        step.data = form.mat.Inverse(form.space.FreeDofs(), inverse="sparsecholesky") * residual
        energy, descent = form.Energy(state.vec), abs(ngs.InnerProduct(step, residual))
        scale = 1.0
        for _ in range(12):
            trial.data = state.vec - scale * step
            after = form.Energy(trial)
            if after <= energy + 1e-10 * abs(energy):  # also false for a folded element: the logarithm is not a number
                break
            scale /= 2
        state.vec.data = trial
        if descent**0.5 < tolerance:
            return
    msg = f"the reference did not converge: energy norm of the last step {descent**0.5:.2g}"
    raise RuntimeError(msg)


def main() -> None:
    """Prints one JSON object: reference, lattice and relative differences."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", type=float, nargs="+", default=[0.45, 0.36], help="element sizes [mm]")
    parser.add_argument("--depths", type=float, nargs="+", default=[0.5, 1.0], help="depths [mm]")
    parser.add_argument("--spacings", type=float, nargs="*", default=[1.0, 0.5], help="lattice spacings [mm]")
    parser.add_argument("--order", type=int, default=2, help="degree of the reference")
    options = parser.parse_args()
    references = [
        reference for size in options.elements
        for reference in reference_forces(options.depths, element_mm=size, order=options.order)
    ]  # fmt: skip
    best = {reference.depth_mm: reference.force_n for reference in references}
    ball = parse_object(f"sphere:radius_mm={RADIUS_MM:g}")
    lattice = []
    for spacing in options.spacings:
        design = load_preset(ElastomerDesign, "design", "uniform-block", [f"lattice.spacing_mm={spacing}"])
        for depth in options.depths:
            result = press(design, ball, depth_mm=depth)
            lattice.append(
                {"spacing_mm": spacing, "depth_mm": depth, "force_n": result.force_n[2],
                 "relative_error": result.force_n[2] / best[depth] - 1, "iterations": result.iterations,
                 "contact_area_mm2": result.contact_area_mm2,
                 "max_penetration_mm": result.max_penetration_mm, "seconds": result.seconds}
            )  # fmt: skip
    print(json.dumps({"reference": [asdict(reference) for reference in references], "lattice": lattice}, indent=1))


if __name__ == "__main__":
    main()
