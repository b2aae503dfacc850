"""What of a touch's detail a frame keeps: contrast against a converged image, by spatial frequency.

    python benchmarks/detail.py --out docs/benchmarks/detail.json [--images 12] [--set render.samples=8]

Dots and lines of 0.3 mm, print on a plate that touches, and the rim of a dent are rendered as a frame of an episode is,
with several seeds, and without an anchor by many independent images. Of what each changes of the untouched sensor's
image, in a window around the contact, the transfer at a frequency is

    T = Re <D C1*> / Re <C2 C1*>,

D being the frame's change, C1 and C2 those of two independent halves of the converged images, means over directions:
noise of the three does not correlate, so that T is 1 where contrast is kept, whatever the noise. Its interval is a
bootstrap over seeds and halves' images. `image` is the same of the whole image instead of its change.
"""

import argparse
import json
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import trimesh

from magicsim.judge.measures import ends
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.simulation.sensor import Sensor

Array = npt.NDArray[np.float64]
WINDOW_MM = 12.0
"""Edge of the square around the contact."""
BANDS_PER_MM = ((0.1, 0.5), (0.5, 1.0), (1.0, 1.5), (1.5, 2.0))
"""Spatial frequencies [1/mm]."""
CONVERGED = ("render.samples=16", "render.particles=400000", "render.anchor_samples=0")
SEEDS = (1, 2, 3, 4)
DRAWS = 200
PLATE_MM, STRIPE_MM, STEP_MM = 8.0, 0.5, 0.125
"""Edge of the printed plate, width of its stripes, edge of the squares that it is drawn with."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Transfer:
    """One object, one band."""

    case: str
    of: str
    """The change of the untouched image, or the image."""
    band_per_mm: tuple[float, float]
    transfer: float
    low: float
    high: float
    share: float
    """Of the band in all that the change (or image) holds up to 2 per mm."""


def cases(folder: Path) -> dict[str, tuple[str, ...]]:
    """Scenes by name."""
    path = folder / "print.ply"
    _printed_plate().export(path)
    plate = f"object={{kind='mesh',path='{path}',file_colors=true,feature_mm=1.0}}"
    return {
        "dots of 0.3 mm": _pressed("dots", 0.4, radius_mm=0.15, spacing_mm=0.9, size_mm=6),
        "lines of 0.3 mm": _pressed("lines", 0.4, width_mm=0.3, spacing_mm=0.9, size_mm=6),
        "print that touches": (plate, "keyframes=[{frame=0,gap_mm=-0.2}]"),
        "rim of a dent": _pressed("sphere", 0.8, radius_mm=4),
    }


def _pressed(kind: str, depth_mm: float, **fields: float) -> tuple[str, ...]:
    values = ",".join(f"{name}={value}" for name, value in fields.items())
    color = "color=[0.85,0.45,0.15]"
    return f"object={{kind='{kind}',{values},{color}}}", f"keyframes=[{{frame=0,gap_mm=-{depth_mm}}}]"


def _printed_plate() -> trimesh.Trimesh:
    """A plate with stripes of two colours on the side that touches."""
    steps = round(PLATE_MM / STEP_MM)
    plate = trimesh.creation.box((PLATE_MM, PLATE_MM, 2.0))
    while plate.edges_unique_length.max() > PLATE_MM / steps * 1.5:
        plate = plate.subdivide()
    dark = np.floor(plate.vertices[:, 0] / STRIPE_MM + 0.5).astype(int) % 2 == 0
    colors = np.where(dark[:, None], [40, 40, 60, 255], [230, 150, 60, 255]).astype(np.uint8)
    return trimesh.Trimesh(plate.vertices, plate.faces, vertex_colors=colors, process=False)


def spectrum(image: Array, camera_field_mm: float) -> tuple[Array, Array]:
    """Fourier coefficients of a window in the middle, shape (n, n, 3), and their frequency, shape (n, n) [1/mm]."""
    rows, columns = image.shape[:2]
    pixel_mm = camera_field_mm / columns
    half = round(WINDOW_MM / pixel_mm / 2)
    part = image[rows // 2 - half : rows // 2 + half, columns // 2 - half : columns // 2 + half]
    taper = np.hanning(2 * half)
    part = (part - part.mean((0, 1))) * (taper[:, None] * taper)[..., None]
    along = np.fft.fftfreq(2 * half, pixel_mm)
    return np.fft.fft2(part, axes=(0, 1)), np.hypot(along[:, None], along)


def transfers(case: str, of: str, frames: list[Array], converged: list[Array], field_mm: float) -> list[Transfer]:
    """Of some frames against independent images of the same state; each shape (rows, columns, 3)."""
    _, frequency = spectrum(frames[0], field_mm)
    ours = np.array([spectrum(each, field_mm)[0] for each in frames])
    theirs = np.array([spectrum(each, field_mm)[0] for each in converged])
    half, chance = len(theirs) // 2, np.random.default_rng(0)
    whole = float((np.abs(theirs.mean(0)) ** 2)[(frequency > BANDS_PER_MM[0][0]) & (frequency <= 2)].sum())

    def measure(chosen: npt.NDArray[np.int64], one: npt.NDArray[np.int64], two: npt.NDArray[np.int64]) -> list[float]:
        frame, first, second = ours[chosen].mean(0), theirs[one].mean(0), theirs[half + two].mean(0)
        found = []
        for low, high in BANDS_PER_MM:
            band = (frequency > low) & (frequency <= high)
            shown = ((frame * first.conj()).real + (frame * second.conj()).real)[band].sum() / 2
            found.append(float(shown / (second * first.conj()).real[band].sum()))
        return found

    everything = measure(np.arange(len(ours)), np.arange(half), np.arange(half))
    drawn = [
        measure(chance.integers(len(ours), size=len(ours)), *chance.integers(half, size=(2, half)))
        for _ in range(DRAWS)
    ]
    low, high = np.transpose([ends(each) for each in np.transpose(drawn)])
    return [
        Transfer(
            case=case, of=of, band_per_mm=band, transfer=everything[k], low=float(low[k]), high=float(high[k]),
            share=float((np.abs(theirs.mean(0)) ** 2)[(frequency > band[0]) & (frequency <= band[1])].sum()) / whole,
        )
        for k, band in enumerate(BANDS_PER_MM)
    ]  # fmt: skip


def measure_case(case: str, scene_settings: tuple[str, ...], settings: list[str], images: int) -> list[Transfer]:
    """All bands of one object."""
    frames, changes = [], []
    for seed in SEEDS:
        scene = load_scene("pressed", [*scene_settings, *settings, f"render.anchor_seed={seed}"], seed=seed)
        sensor, state = Sensor.for_scene(scene), timeline(scene)[0]
        if seed == SEEDS[0]:
            assert state.can_touch
            deformation = sensor.deform(state, sensor.rest)
        frames.append(sensor.radiance(state, deformation).astype(np.float64))
        changes.append(frames[-1] - sensor.radiance(UNTOUCHED, sensor.rest))
    careful = Sensor.for_scene(load_scene("pressed", [*scene_settings, *CONVERGED], seed=0))
    views = [careful.view(state, deformation), careful.view(UNTOUCHED, careful.rest)]
    pairs = [[careful.renderer.plain_radiance(view, turn=1 + k).astype(np.float64) for view in views]
             for k in range(images)]  # fmt: skip
    field_mm = scene.rig.camera.field_mm
    return [
        *transfers(case, "change", changes, [one - rest for one, rest in pairs], field_mm),
        *transfers(case, "image", frames, [one for one, _ in pairs], field_mm),
    ]


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--images", type=int, default=12)
    parser.add_argument("--set", action="append", default=[], dest="settings")
    parser.add_argument("--only", default="")
    chosen = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for case, scene_settings in cases(Path(folder)).items():
            if chosen.only in case:
                rows += measure_case(case, scene_settings, chosen.settings, chosen.images)
                for row in rows[-2 * len(BANDS_PER_MM) :]:
                    print(json.dumps(asdict(row)), flush=True)
    chosen.out.write_text(
        json.dumps({"settings": chosen.settings, "results": [asdict(row) for row in rows]}, indent=1) + "\n"
    )


if __name__ == "__main__":
    main()
