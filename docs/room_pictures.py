"""Draws what a clear block sees of the room `bench` at several distances.

python docs/room_pictures.py             # writes docs/near-rooms.jpg, a minute

A small block without a grid, strips off, so that nothing but the room is seen: the same picture on spheres of several
radii around the middle of the contact face.
"""

from pathlib import Path

from PIL import Image, ImageDraw

from magicsim import load_scene, simulate
from magicsim.notebook.screen import on_screen

HERE = Path(__file__).parent
ENLARGE, LABEL_PX = 2, 18
SIGHT = (
    "references=0", "design.cell_mm=0", "rig.strips=[]", "rig.room='bench'", "rig.camera.columns=120",
    "rig.camera.rows=140", "render.anchor_samples=256", "rig.camera.full_well_e=1e9", "rig.camera.read_noise_e=0",
)  # fmt: skip
ROOMS = {
    "infinitely far": (),
    "500 mm": ("rig.room_distance_mm=500",),
    "150 mm": ("rig.room_distance_mm=150",),
    "60 mm": ("rig.room_distance_mm=60",),
}


def main() -> None:
    """Writes the sheet."""
    tiles = {}
    for label, settings in ROOMS.items():
        scene = load_scene("rest", [*SIGHT, *settings])
        image = Image.fromarray(on_screen(simulate(scene).frames[-1].image, gamma=scene.rig.camera.gamma))
        tiles[label] = image.resize((ENLARGE * image.width, ENLARGE * image.height), Image.Resampling.BICUBIC)
    width, height = next(iter(tiles.values())).size
    page = Image.new("RGB", (len(tiles) * (width + 4), height + LABEL_PX), "white")
    draw = ImageDraw.Draw(page)
    for number, (label, tile) in enumerate(tiles.items()):
        draw.text((number * (width + 4) + 2, 3), label, fill="black")
        page.paste(tile, (number * (width + 4), LABEL_PX))
    page.save(HERE / "near-rooms.jpg", quality=88)


if __name__ == "__main__":
    main()
