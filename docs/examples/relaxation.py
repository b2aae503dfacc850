"""A body that relaxes: the force rises while the ball comes in and falls while it stays.

python docs/examples/relaxation.py         # force over time, some seconds
"""

from magicsim import press
from magicsim.config.models import load_preset
from magicsim.deform.indentation.path import PathForce
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object


def history(settings: list[str], *, speed_mm_s: float = 1.0, hold_s: float = 10.0) -> tuple[PathForce, ...]:
    """Force over time of a ball pressed 0.5 mm deep and held there."""
    design = load_preset(ElastomerDesign, "design", "mini-magictac-rate", settings)
    ball = parse_object("sphere:radius_mm=4")
    return press(design, ball, depth_mm=0.5, speed_mm_s=speed_mm_s, hold_s=hold_s).history


if __name__ == "__main__":
    for moment in history([]):
        print(f"{moment.time_s:8.2f} s  {moment.force_n[2]:.3f} N")
