"""A thicker skin is harder, a deeper core is softer: one press on three designs.

python docs/examples/skin_and_core.py      # three forces, a quarter of a minute
"""

from magicsim import press
from magicsim.config.models import load_preset
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object

DESIGNS = {
    "default": [],
    "thicker skin": ["skin_mm=1.6"],
    "deeper core": ["core_mm=8"],
}


def force_n(settings: list[str], *, depth_mm: float = 0.6) -> float:
    """Normal force of a ball on mini-MagicTac with some settings changed [N]."""
    design = load_preset(ElastomerDesign, "design", "mini-magictac", settings)
    return press(design, parse_object("sphere:radius_mm=5"), depth_mm=depth_mm).force_n[2]


if __name__ == "__main__":
    for name, settings in DESIGNS.items():
        print(f"{name}: {force_n(settings):.3f} N")
