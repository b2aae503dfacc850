"""A material of your own: other numbers in a design, and what they do to force and light.

python docs/examples/own_material.py       # a table, half a minute
"""

from magicsim import load_design, load_object, press

SILICONE = (
    "materials.body.youngs_modulus_mpa=0.2",
    "materials.body.poisson_ratio=0.48",
    "materials.body.ior=1.41",
)
"""A soft clear silicone: assumed values, of the order that data sheets give."""


def force_n(settings: list[str]) -> float:
    """Normal force of a ball of radius 4 mm, 0.5 mm deep [N]."""
    return press(load_design("mini-magictac", settings), load_object("sphere:radius_mm=4"), depth_mm=0.5).force_n[2]


def scaled(factor: float) -> list[str]:
    """All moduli of the default design times a factor."""
    body, infill = load_design("mini-magictac").materials.body, load_design("mini-magictac").materials.infill
    return [
        f"materials.body.youngs_modulus_mpa={factor * body.youngs_modulus_mpa}",
        f"materials.infill.shear_modulus_mpa={factor * infill.shear_modulus_mpa}",
        f"materials.infill.bulk_modulus_mpa={factor * infill.bulk_modulus_mpa}",
    ]


if __name__ == "__main__":
    print(f"default: {force_n([]):.3f} N")
    print(f"all moduli doubled: {force_n(scaled(2.0)):.3f} N")
    print(f"silicone walls and skin: {force_n(list(SILICONE)):.3f} N")
