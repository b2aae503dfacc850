"""How far off the labels of force may be, as a dataset states it: shares of the force, by cause.

They say how a real sensor of the same design may differ from the label, beyond what a recipe's tolerances draw. Labels
are quasi-static: they hold for the stiffness at the time of a hardness reading, 1 s after contact; with
`contact.rate_dependent` they follow the relaxation of the body. A cause whose size nobody knows has None,
and so has the total.
"""

import json

from magicsim.dataset.recipes.recipe import Recipe

Share = tuple[float, float]
"""Least and largest relative difference from the label."""
LATTICE: Share = (-0.06, 0.08)
"""Node spacing of a printed cell below round objects, whose labels are 7 % too low to 6 % too high, and finer ones at
the edges of punches and boxes (docs/physics/mechanics.md, "How far off it is")."""
EDGES: Share = (-0.16, 0.16)
"""Node spacing below edges and textures that get no planes of their own."""
FLAT_KINDS = frozenset({"cone", "dots", "lines", "mesh"})
"""Objects with such edges or textures."""
TIME: Share = (-0.29, 0.6)
"""Relaxation of Agilus30 from 0.1 to 60 s of contact; the stiffness is that after 1 s (docs/validation.md)."""
TIME_OF_READING: Share = (0.0, 1.6)
"""What a relaxing body leaves of it: its times are scaled to a hardness reading 1 s after contact; for one after 15 s
the stiffness is 2.6 times as large after 0.1 s and 1.2 times after 60 s (docs/validation.md)."""
MODULI: Share = (-0.25, 0.1)
"""What two fitted stiffnesses leave of seven other hardness readings (docs/validation.md): most are read too hard."""
LEAST_HEIGHT_MM = 5.0
"""Least height for which that was found out; thinner blocks are read too hard by an unknown part."""


def force_error(recipe: Recipe) -> dict[str, Share | None]:
    """Shares by cause, and their root of squares as `total`; None where the error is not known.

    Args:
        recipe: Of the dataset.
    """
    kinds = {each.kind for each in recipe.objects}
    parts = {
        "lattice": EDGES if kinds & FLAT_KINDS else LATTICE,
        "time": TIME_OF_READING if recipe.contact.rate_dependent else TIME,
    }
    if recipe.design.height_mm < LEAST_HEIGHT_MM:
        return {**parts, "moduli": None, "total": None}
    parts["moduli"] = MODULI
    low, high = (round(float(sum(part[side] ** 2 for part in parts.values()) ** 0.5), 3) for side in (0, 1))
    return {**parts, "total": (-low, high)}


def as_metadata(recipe: Recipe) -> dict[str, str]:
    """For the field of a Parquet file, as JSON under `relative_error`; null is an error that is not known."""
    return {"relative_error": json.dumps(force_error(recipe))}


def as_sentence(recipe: Recipe) -> str:
    """For the dataset card."""
    told = ", ".join(
        f"{cause} unknown" if share is None else f"{cause} {share[0]:+.0%} to {share[1]:+.0%}"
        for cause, share in force_error(recipe).items()
    )
    when = (
        "follow the body's relaxation from frame to frame, with times that are scaled to a hardness reading 1 s after "
        "contact"
        if recipe.contact.rate_dependent
        else "are quasi-static, for the stiffness 1 s after contact"
    )
    thin = (
        f" A block of {recipe.design.height_mm:g} mm is below {LEAST_HEIGHT_MM:g} mm: its forces are too high by an "
        "unknown part."
        if recipe.design.height_mm < LEAST_HEIGHT_MM
        else ""
    )
    return (
        f"`force_n` comes with a stated error, in shares of it by which a real sensor may differ: {told}.{thin} Labels "
        f"{when}; the same numbers stand in the metadata of the column."
    )
