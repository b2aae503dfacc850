"""Force against depth of a ball, and how much of it the lattice's spacing decides.

python docs/examples/force_curve.py        # a table, half a minute
"""

from magicsim import press_curve
from magicsim.config.models import load_preset
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object

BALL = parse_object("sphere:radius_mm=4")


def forces_n(depths_mm: tuple[float, ...], *, spacing_mm: float) -> list[float]:
    """Normal force of a ball on the plain block at each depth [N]."""
    block = load_preset(ElastomerDesign, "design", "uniform-block", [f"lattice.spacing_mm={spacing_mm}"])
    return press_curve(block, BALL, depths_mm).forces_n[:, 2].tolist()


if __name__ == "__main__":
    depths = (0.25, 0.5, 0.75, 1.0)
    coarse, fine = (forces_n(depths, spacing_mm=spacing) for spacing in (1.0, 0.5))
    for depth, one, other in zip(depths, coarse, fine, strict=True):
        print(f"{depth:.2f} mm: {one:.3f} N with nodes 1 mm apart, {other:.3f} N with 0.5 mm")
