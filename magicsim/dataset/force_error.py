"""How far off the labels of force may be, as a dataset states it: shares of the force, by cause.

They say how a real sensor of the same design may differ from the label, beyond what a recipe's tolerances draw. Labels
are quasi-static: they hold for the stiffness at the time of a hardness reading, 1 s after contact.
"""

import json

from magicsim.dataset.recipes.recipe import Recipe

Share = tuple[float, float]
"""Least and largest relative difference from the label."""
LATTICE: Share = (-0.05, 0.05)
"""Node spacing of a printed cell below round objects, and finer ones at the edges of punches and boxes
(docs/physics/mechanics.md, "How far off it is")."""
EDGES: Share = (-0.16, 0.16)
"""Node spacing below edges and textures that get no planes of their own."""
FLAT_KINDS = frozenset({"cone", "dots", "lines", "mesh"})
"""Objects with such edges or textures."""
TIME: Share = (-0.29, 0.6)
"""Relaxation of Agilus30 from 0.1 to 60 s of contact; the stiffness is that after 1 s (docs/validation.md)."""
MODULI: Share = (-0.25, 0.1)
"""What two fitted stiffnesses leave of seven other hardness readings (docs/validation.md): most are read too hard."""


def force_error(recipe: Recipe) -> dict[str, Share]:
    """Shares by cause, and their root of squares as `total`.

    Args:
        recipe: Of the dataset.
    """
    kinds = {each.kind for each in recipe.objects}
    parts = {"lattice": EDGES if kinds & FLAT_KINDS else LATTICE, "time": TIME, "moduli": MODULI}
    low, high = (round(float(sum(part[side] ** 2 for part in parts.values()) ** 0.5), 3) for side in (0, 1))
    return parts | {"total": (-low, high)}


def as_metadata(recipe: Recipe) -> dict[str, str]:
    """For the field of a Parquet file, as JSON under `relative_error`."""
    return {"relative_error": json.dumps(force_error(recipe))}


def as_sentence(recipe: Recipe) -> str:
    """For the dataset card."""
    told = ", ".join(f"{cause} {low:+.0%} to {high:+.0%}" for cause, (low, high) in force_error(recipe).items())
    return (
        f"`force_n` comes with a stated error, in shares of it by which a real sensor may differ: {told}. Labels "
        "are quasi-static, for the stiffness 1 s after contact; the same numbers stand in the metadata of the column."
    )
