"""Draws what each flaw of a print does to a frame, far stronger than a good print where that is needed.

python docs/print_pictures.py             # writes docs/print-flaws.jpg, some minutes

Yellow scissors a millimetre before a small copy of the default sensor, in the default room; the middle of the image.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from magicsim import load_scene, simulate
from magicsim.notebook.screen import on_screen

Frame = npt.NDArray[np.uint8]
HERE = Path(__file__).parent
CROP = (slice(30, 130), slice(20, 120))
ENLARGE, LABEL_PX, ACROSS = 3, 18, 4
BEFORE = (
    'object="yellow-scissors"', "references=0", "keyframes=[{frame=0,gap_mm=1.0}]", "design.inclusions.seed=2",
    "design.footprint_mm=[14,16]", "rig.camera.columns=140", "rig.camera.rows=160", "rig.camera.field_mm=12.5",
)  # fmt: skip
LEDS = ",".join(
    f"{{side='{side}',radiance=[{red},{green},{blue}]}}"
    for side, red, green, blue in (("-x", 5, 0, 0), ("+x", 0, 0, 4), ("-y", 0, 6, 0), ("+y", 0, 4, 0))
)
FLAWS: dict[str, tuple[str, ...]] = {
    "as drawn": (),
    "uneven walls": ("design.unevenness.wall_sd_mm=0.015", "design.unevenness.wave_sd_mm=0.03"),
    "pitch drifts by 8 %": ("design.unevenness.pitch_drift=[0.08,-0.08,0]",),
    "uneven skin, 0.06 mm": ("design.unevenness.skin_sd_mm=0.06", "design.unevenness.skin_length_mm=4"),
    "5 % of walls missing": ("design.unevenness.torn_share=0.05",),
    "fillets of 0.15 mm": ("design.unevenness.crossing_radius_mm=0.15",),
    "rough skin, 0.1": ("design.roughness.skin=0.1",),
    "rough walls, 0.2": ("design.roughness.walls=0.2",),
    "bubbles, 1 per mm3": ("design.inclusions.bubbles_per_mm3=1",),
    "flakes, 1 per mm3": ("design.inclusions.flakes_per_mm3=1",),
    "LEDs of uneven colour": (f"rig.strips=[{LEDS}]",),
    "several of them": (
        "design.unevenness.wall_sd_mm=0.015",
        "design.unevenness.crossing_radius_mm=0.15",
        "design.roughness.skin=0.1",
        "design.roughness.walls=0.2",
        "design.inclusions.bubbles_per_mm3=1",
        "design.inclusions.flakes_per_mm3=1",
    ),
}


def frame(*settings: str) -> Frame:
    """The only frame of the scene with some settings, as a screen shows it."""
    scene = load_scene("near", [*BEFORE, *settings])
    return on_screen(simulate(scene).frames[-1].image, gamma=scene.rig.camera.gamma)


def sheet(pictures: dict[str, Frame]) -> Image.Image:
    """All pictures with their labels."""
    tiles = {label: Image.fromarray(picture[CROP]) for label, picture in pictures.items()}
    width, height = (ENLARGE * size for size in next(iter(tiles.values())).size)
    rows = -(-len(tiles) // ACROSS)
    page = Image.new("RGB", (ACROSS * (width + 4), rows * (height + LABEL_PX + 4)), "white")
    draw = ImageDraw.Draw(page)
    for number, (label, tile) in enumerate(tiles.items()):
        left, top = (number % ACROSS) * (width + 4), number // ACROSS * (height + LABEL_PX + 4)
        draw.text((left + 2, top + 3), label, fill="black")
        page.paste(tile.resize((width, height), Image.Resampling.NEAREST), (left, top + LABEL_PX))
    return page


if __name__ == "__main__":
    sheet({label: frame(*settings) for label, settings in FLAWS.items()}).save(HERE / "print-flaws.jpg", quality=88)
