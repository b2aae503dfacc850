"""How far a touch's change of the image is from converged images: by depth, distance from the contact, and length.

    python benchmarks/frame_error.py --out docs/benchmarks/frame-error.json [--images 8] [--depths 0.3,0.6,1,1.5]
    python benchmarks/frame_error.py --out docs/benchmarks/tiers.json --tiers true,control,fast,volpath

An object is pressed into the middle of the face, filmed by a camera without noise. Of each depth a frame is rendered as
an episode has it, and without an anchor by many independent images, in two halves. The error of the change is

    e^2 = mean (D - C1) (D - C2),

D being what the frame differs by from the untouched sensor's, C1 and C2 the same of the halves, so that their own noise
adds nothing; the change's own size is the mean of C1 C2. `grain` is the part of the error above a Gaussian mean of five
pixels' width at half height, `slow` what is below it. `spread` is the standard deviation over seeds, each with pixel
positions and light particles of its own. All are grey levels of an exposure that brings the untouched frame to its
level, before they are rounded: far is 8 mm and more from the contact, corners are squares of 60 pixels. `mean`, `p99`
are distances from the mean of both halves, whose own noise is among them. Several tiers are compared before contact
under a flashlight (`lit`), too. `seconds` of a processor are those of one
image, what is computed once left out. The plot, beside the figures, shows all of it over the depth. Of several tiers it
shows error against time, and beside it that of the force at each `contact.quality`, against a finer lattice.
"""

import argparse
import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt, gaussian_filter

from magicsim.camera.exposure import meter
from magicsim.camera.projection import pixel_landing_mm
from magicsim.deform.quality import SOLVE_QUALITIES
from magicsim.geometry.objects.kinds import parse_object
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState
from magicsim.simulation.sensor import Sensor
from magicsim.simulation.truth import contact_mask

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
CLEAN = ("rig.camera.read_noise_e=0", "rig.camera.full_well_e=1e9", "references=1")
CONVERGED = ("render.samples=16", "render.particles=400000", "render.anchor_samples=0")
OBJECTS = {
    "ball": "sphere:radius_mm=5", "punch": "punch:radius_mm=3", "box": "box:size_mm=6",
    "cylinder": "cylinder:radius_mm=3,length_mm=40", "cover": "box:size_mm=40",
}  # fmt: skip
TIERS = {
    "true": (), "fast": ("render.tier=fast", "render.outside_domain=refuse"),
    "control": ("render.samples=1", "render.particles=6000"),
    "volpath": ("render.estimator=path", "render.samples=64"),
}  # fmt: skip
"""Settings of each; `volpath` is Mitsuba's own path tracer."""
FINER = (
    "design.lattice.growth=1.2", "design.lattice.cells_across=8", "design.lattice.cells_across_round=0",
    "design.lattice.edge_nodes=2000",
)  # fmt: skip
"""Settings of the lattice that forces are compared with."""
FAR_MM, CORNER_PX, FINE_PX = 8.0, 60, 5 / 2.355
NEAR_MM = 1.0
"""Gap of the frame before contact."""
SEEDS = (1, 2, 3, 4)


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameError:
    """One state, one part of the image; grey levels, root mean square."""

    object: str
    depth_mm: float
    """Negative before contact."""
    lit: bool
    """Whether the flashlight is on."""
    region: str
    change: float
    error: float
    grain: float
    slow: float
    spread: float
    mean: float
    p99: float
    tier: str
    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceError:
    """The force of one press from rest."""

    object: str
    depth_mm: float
    quality: str
    force_n: float
    error: float
    """Relative, against the finer lattice."""
    seconds: float
    """Of a processor."""


def pressed(depth_mm: float, *, lit: bool = False) -> FrameState:
    """An object in the middle of the face."""
    return FrameState(gap_mm=-depth_mm, x_mm=0, y_mm=0, twist_deg=0.0, flashlight=lit, light_x_mm=0)


def regions(touched: Mask, pixel_mm: float) -> dict[str, Mask]:
    """Parts of an image, each shape (rows, columns).

    Args:
        touched: What touches, of the same shape; where nothing does, the middle counts.
        pixel_mm: Edge of a pixel on the contact face.
    """
    rows, columns = touched.shape
    if not touched.any():
        touched = np.zeros_like(touched)
        touched[rows // 2, columns // 2] = True
    far = distance_transform_edt(~touched) * pixel_mm >= FAR_MM
    corners = np.zeros_like(far)
    for down in (slice(0, CORNER_PX), slice(rows - CORNER_PX, rows)):
        for across in (slice(0, CORNER_PX), slice(columns - CORNER_PX, columns)):
            corners[down, across] = True
    return {"far": far, "corners": corners, "elsewhere": ~far, "whole": np.ones_like(far)}


def rms(first: Array, second: Array, part: Mask) -> float:
    """Root of the mean product over a part of the image."""
    return float(np.sqrt(max(0.0, (first * second)[part].mean())))


def smooth(image: Array) -> Array:
    """Its Gaussian mean."""
    return np.asarray(gaussian_filter(image, FINE_PX, axes=(0, 1)))


def rendered(sensors: list[Sensor], state: FrameState, deformation: object) -> tuple[list[Array], float]:
    """A frame of each sensor, and the seconds of a processor that one takes at last."""
    frames = []
    for sensor in sensors:
        begin = time.process_time()
        frames.append(sensor.radiance(state, deformation).astype(np.float64))
    return frames, time.process_time() - begin


def measure(
    name: str, depths: list[float], settings: list[str], images: int, tiers: tuple[str, ...] = ("true",)
) -> list[FrameError]:
    """All depths of one object, by one tier after the other."""
    sensors = {}
    for tier in tiers:
        scenes = [load_scene("pressed", [*CLEAN, *settings, *TIERS[tier]], seed=seed) for seed in SEEDS]
        target = parse_object(OBJECTS[name])
        sensors[tier] = [Sensor.for_scene(each.model_copy(update={"object": target})) for each in scenes]
    careful_scene = load_scene("pressed", [*CLEAN, *settings, *CONVERGED], seed=0)
    careful = Sensor.for_scene(careful_scene.model_copy(update={"object": parse_object(OBJECTS[name])}))
    first = sensors[tiers[0]][0]
    rests = {tier: rendered(each, UNTOUCHED, first.rest)[0] for tier, each in sensors.items()}
    gain = 255 * meter(rests[tiers[0]][0], first.rig.camera)

    def halves(state: FrameState, deformation: object) -> list[Array]:
        view = careful.view(state, deformation)
        shown = [careful.renderer.plain_radiance(view, turn=1 + turn).astype(np.float64) for turn in range(images)]
        return [gain * np.mean(shown[half::2], 0) for half in range(2)]

    landing_mm = pixel_landing_mm(first.design, first.rig.lens, first.rig.camera)
    at_rest, found = halves(UNTOUCHED, careful.rest), []
    states = [pressed(each) for each in depths]
    if len(tiers) > 1:
        states.insert(1, pressed(depths[0], lit=True))
    for state in states:
        depth_mm = -float(state.gap_mm or 0)
        deformation = first.deform(state, first.rest) if depth_mm > 0 else first.rest
        truth = [now - rest for now, rest in zip(halves(state, deformation), at_rest, strict=True)]
        mask = contact_mask(deformation, landing_mm)
        for tier in tiers:
            frames, _ = rendered(sensors[tier], state, deformation)
            # One image more, when all is compiled, and what the frames of a press share is known.
            before = pressed(0.8 * depth_mm, lit=state.flashlight)
            held = first.deform(before, first.rest) if depth_mm > 0 else first.rest
            _, seconds = rendered(sensors[tier][-1:], before, held)
            changes = [gain * (frame - rest) for frame, rest in zip(frames, rests[tier], strict=True)]
            errors = [[change - each for each in truth] for change in changes]
            off = np.abs([np.mean(each, 0) for each in errors])
            for region, part in regions(mask, first.rig.camera.field_mm / first.rig.camera.columns).items():
                slow = np.mean([rms(smooth(one), smooth(two), part) ** 2 for one, two in errors])
                whole = np.mean([rms(one, two, part) ** 2 for one, two in errors])
                fine = np.mean([rms(one - smooth(one), two - smooth(two), part) ** 2 for one, two in errors])
                row = FrameError(
                    object=name, depth_mm=depth_mm, lit=state.flashlight, region=region, change=rms(*truth, part),
                    error=float(np.sqrt(whole)), grain=float(np.sqrt(fine)), slow=float(np.sqrt(slow)),
                    spread=float(np.sqrt(np.var(changes, axis=0, ddof=1)[part].mean())),
                    mean=float(off[:, part].mean()), p99=float(np.percentile(off[:, part], 99)), tier=tier,
                    seconds=round(seconds, 3),
                )  # fmt: skip
                found.append(row)
                print(json.dumps(asdict(row)), flush=True)
    return found


def forces(name: str, depths: list[float], settings: list[str]) -> list[ForceError]:
    """Presses of one object at each quality, once all is compiled."""

    def solved(depth_mm: float, *more: str) -> tuple[float, float]:
        scene = load_scene("pressed", [*settings, *more]).model_copy(update={"object": parse_object(OBJECTS[name])})
        sensor = Sensor.for_scene(scene, states=[pressed(depth_mm)])
        begin = time.process_time()
        force = float(sensor.deform(pressed(depth_mm), sensor.rest).force_n[2])
        return force, time.process_time() - begin

    found = []
    for depth_mm in (each for each in (depths[-1], *depths) if each > 0):
        true, _ = solved(depth_mm, *FINER)
        for quality in SOLVE_QUALITIES:
            force, seconds = solved(depth_mm, f"contact.quality={quality}")
            found.append(
                ForceError(
                    object=name, depth_mm=depth_mm, quality=quality, force_n=round(force, 4),
                    error=round(force / true - 1, 5), seconds=round(seconds, 3),
                )
            )  # fmt: skip
    return found[len(SOLVE_QUALITIES) :]


def draw(rows: list[FrameError], path: Path) -> None:
    """Errors over the depth, a panel for each object and region."""
    mpl.use("Agg")
    names, parts = list(dict.fromkeys(row.object for row in rows)), ("far", "elsewhere")
    figure, panels = plt.subplots(
        len(parts), len(names), figsize=(4 * len(names), 6), squeeze=False, sharex=True, sharey="row"
    )
    for down, region in enumerate(parts):
        for across, name in enumerate(names):
            panel = panels[down][across]
            chosen = [row for row in rows if row.object == name and row.region == region]
            for field in ("change", "error", "grain", "slow", "spread"):
                panel.plot([row.depth_mm for row in chosen], [getattr(row, field) for row in chosen], "o-", label=field)
            panel.axhline(0.25, color="grey", linestyle=":", label="noise of the camera")
            panel.set(title=f"{name}, {region}", xlabel="depth [mm]", yscale="log")
    panels[0][0].set_ylabel("grey levels, rms")
    panels[0][0].legend(fontsize=7, loc="lower right")
    figure.tight_layout()
    figure.savefig(path, dpi=120)


def draw_tiers(rows: list[FrameError], presses: list[ForceError], path: Path) -> None:
    """Error of the whole image and of the force against seconds of a processor, one mark a tier and state."""
    mpl.use("Agg")
    figure, panels = plt.subplots(1, 3, figsize=(14, 4))
    for quality in SOLVE_QUALITIES:
        these = [each for each in presses if each.quality == quality]
        panels[2].plot([each.seconds for each in these], [100 * abs(each.error) for each in these], "o", label=quality)
    panels[2].set(title="touched", xlabel="processor time of a press from rest [s]", xscale="log", yscale="log",
                  ylabel="error of the force [%]")  # fmt: skip
    panels[2].legend(fontsize=8)
    panels[1].sharex(panels[0])
    panels[1].sharey(panels[0])
    for panel, title in zip(panels[:2], ("before contact", "touched"), strict=True):
        for tier in dict.fromkeys(row.tier for row in rows):
            states = [row for row in rows if row.region == "whole" and (row.depth_mm > 0) == (title == "touched")]
            chosen = [row for row in states if row.tier == tier]
            panel.plot([row.seconds for row in chosen], [row.error for row in chosen], "o", label=tier)
        panel.axhline(0.25, color="grey", linestyle=":", label="noise of the camera")
        panel.set(title=title, xlabel="processor time of an image [s]", xscale="log", yscale="log")
    panels[0].set_ylabel("error of the change [grey levels, rms]")
    panels[0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=120)


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--images", type=int, default=8, help="Converged ones of each state, an even number.")
    parser.add_argument("--depths", default="0.1,0.3,0.6,1,1.5,2")
    parser.add_argument("--objects", default=",".join(OBJECTS))
    parser.add_argument("--tiers", default="true", help=f"Some of {', '.join(TIERS)}.")
    parser.add_argument("--set", action="append", default=[], dest="settings")
    chosen = parser.parse_args()
    depths = [-NEAR_MM, *map(float, chosen.depths.split(","))]
    names, tiers = chosen.objects.split(","), tuple(chosen.tiers.split(","))
    rows = [row for name in names for row in measure(name, depths, chosen.settings, chosen.images, tiers)]
    presses = [each for name in names for each in forces(name, depths, chosen.settings)] if len(tiers) > 1 else []
    figures = {"settings": chosen.settings, "images": chosen.images, "results": [asdict(row) for row in rows],
               "forces": [asdict(each) for each in presses]}  # fmt: skip
    chosen.out.write_text(json.dumps(figures, indent=1) + "\n")
    if presses:
        draw_tiers(rows, presses, chosen.out.with_suffix(".png"))
    else:
        draw(rows, chosen.out.with_suffix(".png"))


if __name__ == "__main__":
    main()
