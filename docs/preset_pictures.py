"""Draws every sensor of docs/faces.md, untouched, with a small box pressed into its face, and the change of that.

python docs/preset_pictures.py             # writes docs/presets.jpg, some minutes

Each as its own camera frames it, with fewer pixels.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from magicsim import load_scene, simulate
from magicsim.notebook.screen import change, on_screen

Frame = npt.NDArray[np.uint8]
HERE = Path(__file__).parent
NAMES = (
    "mini-magictac-finger", "gelsight-type", "gelsight-type-markers", "marker-type", "see-through-markers",
    "translucent-9dtact",
)  # fmt: skip
PRESSED = (
    "object={kind='box',size_mm=[4.0,6.0,4.0],edge_radius_mm=0.3,yaw_deg=25.0,color=[0.85,0.45,0.15]}",
    "keyframes=[{frame=0},{frame=1,gap_mm=-0.6}]", "references=0",
)  # fmt: skip
DEEPER = {"translucent-9dtact": ("keyframes=[{frame=0},{frame=1,gap_mm=-1.2}]",)}
"""Settings of a gel that scatters, in which a shallow touch is dim."""
SHORT_PX, LABEL_PX, ACROSS, SPACE_PX = 120, 18, 2, 4
TILE_PX = (220, 220)


def frames(name: str) -> list[Frame]:
    """The untouched and the touched frame of a sensor as a screen shows them, and what the touch changes."""
    camera = load_scene(name).rig.camera
    scale = SHORT_PX / min(camera.columns, camera.rows)
    size = [f"rig.camera.{axis}={round(scale * getattr(camera, axis))}" for axis in ("columns", "rows")]
    images = [each.image for each in simulate(load_scene(name, [*PRESSED, *size, *DEEPER.get(name, ())])).frames]
    return [*(on_screen(each, gamma=camera.gamma) for each in images), change(images[1], images[0])]


def sheet(pictures: dict[str, list[Frame]]) -> Image.Image:
    """All sensors with their labels: untouched, touched, and the change."""
    width, height = 3 * TILE_PX[0] + 4 * SPACE_PX, TILE_PX[1] + LABEL_PX + SPACE_PX
    page = Image.new("RGB", (ACROSS * width, -(-len(pictures) // ACROSS) * height), "white")
    draw = ImageDraw.Draw(page)
    for number, (label, tiles) in enumerate(pictures.items()):
        left, top = (number % ACROSS) * width, number // ACROSS * height
        draw.text((left + 2, top + 3), label, fill="black")
        for place, frame in enumerate(tiles):
            tile = Image.fromarray(frame)
            tile.thumbnail(TILE_PX)
            grown = min(TILE_PX[0] / tile.width, TILE_PX[1] / tile.height)
            tile = tile.resize((round(grown * tile.width), round(grown * tile.height)), Image.Resampling.BICUBIC)
            page.paste(tile, (left + place * (TILE_PX[0] + SPACE_PX), top + LABEL_PX))
    return page


if __name__ == "__main__":
    sheet({name: frames(name) for name in NAMES}).save(HERE / "presets.jpg", quality=86)
