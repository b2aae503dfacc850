"""Settings that make a scene small enough to render in a test."""

SMALL = [
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=1.2", "rig.camera.columns=24", "rig.camera.rows=32",
    "design.lattice.cells_across=0",
    "rig.camera.field_mm=10", "render.samples=2", "render.particles=2000", "render.anchor_samples=2",
    "render.anchor_particles=2000", "references=6",
]  # fmt: skip


def settings(*more: str) -> list[str]:
    return [part for each in (*SMALL, *more) for part in ("--set", each)]
