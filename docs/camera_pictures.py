"""Draws what each effect of the camera does to a frame, far stronger than in a real camera where that is needed.

python docs/camera_pictures.py             # writes docs/camera-effects.png and docs/camera-live.png, about a minute

The untouched default sensor in a lit room, a ball before it, and a flashlight, each rendered once; the middle of the
image is shown. H.264 needs the extra `video`.
"""

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from magicsim.camera.camera import Camera
from magicsim.camera.disturbances import between_frames, transmittance
from magicsim.camera.effect_settings import (
    H264,
    Diffraction,
    Dust,
    Flicker,
    Glare,
    LiveExposure,
    Mjpeg,
    PixelFaults,
    Shutter,
)
from magicsim.camera.film import spread_light
from magicsim.camera.stream import CameraStream, Instant
from magicsim.notebook.screen import on_screen
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor, room_radiance

FloatImage = npt.NDArray[np.float32]
Frame = npt.NDArray[np.uint8]
HERE = Path(__file__).parent
LIT = ("rig.ambient=[0.1,0.1,0.1]", "rig.camera.flicker={}")
CROP = (slice(100, 220), slice(60, 180))
ENLARGE, LABEL_PX, ACROSS = 2, 18, 4
QUIET: dict[str, Any] = {"full_well_e": 1e9, "read_noise_e": 0.0, "fixed_pattern": 0.0}
RATE = 15.0


def rendered(name: str, *settings: str) -> tuple[FloatImage, Sensor]:
    """Radiance of the first frame of a scene, shape (rows, columns, 3), and its sensor."""
    sensor = Sensor.for_scene(load_scene(name, [*LIT, *settings]))
    return sensor.radiance(sensor.states[0], sensor.rest), sensor


def taken(
    camera: Camera, lights: list[FloatImage], untouched: FloatImage, room: FloatImage | None = None
) -> list[Frame]:
    """All frames of a stream."""
    stream = CameraStream.of(camera, untouched, room=room)
    memory, frames = stream.begin(RATE), []
    for index, light in enumerate(lights):
        at = Instant(seed=2, index=index, time_s=index / RATE, frames_per_second=RATE)
        image, memory = stream.take(light, memory, at)
        frames.append(image)
    return frames


def effects(rest: FloatImage, room: FloatImage, ball: FloatImage, moved: FloatImage) -> dict[str, Frame]:
    """One frame of each effect by its label, as a screen shows it."""
    plain = load_scene("rest").rig.camera.model_copy(update=QUIET)

    def one(light: FloatImage, *lights: FloatImage, room: FloatImage | None = None, **changes: object) -> Frame:
        return on_screen(taken(plain.model_copy(update=changes), [light, *lights], rest, room)[-1], gamma=plain.gamma)

    rows, columns, _ = rest.shape
    specks = transmittance(Dust(specks=60, radius_px=6, opacity=0.6), rows=rows, columns=columns, pattern_seed=1)
    rolling = Shutter(exposure_ms=20.0, row_us=140.0)
    spread = spread_light(ball, Diffraction(f_number=16.0, pixel_um=1.75), None)
    return {
        "no effect": one(rest),
        "photon noise, 1000 e": one(rest, full_well_e=1000.0),
        "dark pattern, hot, dead": one(
            rest, full_well_e=4000.0, faults=PixelFaults(dark_e=120, hot_share=2e-3, hot_e=2500, dead_share=2e-3)
        ),
        "row noise, 100 of 4000 e": one(rest, full_well_e=4000.0, faults=PixelFaults(row_e=100)),
        "dust, opacity to 0.6": one((rest * specks[..., None]).astype(np.float32)),
        "ball 1 mm away": one(ball),
        "the same at f/16, 1.75 um": one(spread),
        "the same, glare 0.3": one(spread_light(ball, None, Glare(share=0.3, radius_px=40))),
        "flicker, half the swing 0.9": one(
            rest, room=room, flicker=Flicker(depth=0.9), shutter=Shutter(exposure_ms=2.0, row_us=140.0)
        ),
        "rows between frames": one(between_frames(ball, moved, rolling, frames_per_second=RATE)),
        "MJPEG, quality 15": one(rest, compression=Mjpeg(kind="mjpeg", quality=15, chroma="420")),
        "H.264, crf 40, frame 9": one(rest, *[rest] * 8, full_well_e=4000.0, compression=H264(kind="h264", crf=40)),
    }


def sheet(frames: dict[str, Frame]) -> Image.Image:
    """Enlarged crops with their labels."""
    side = ENLARGE * (CROP[0].stop - CROP[0].start)
    down = -(-len(frames) // ACROSS)
    found = Image.new("RGB", (ACROSS * (side + 6) - 6, down * (side + LABEL_PX + 6) - 6), "white")
    draw = ImageDraw.Draw(found)
    for number, (label, frame) in enumerate(frames.items()):
        left, top = number % ACROSS * (side + 6), number // ACROSS * (side + LABEL_PX + 6)
        draw.text((left + 3, top + 3), label, fill="black")
        found.paste(Image.fromarray(frame[CROP].repeat(ENLARGE, 0).repeat(ENLARGE, 1)), (left, top + LABEL_PX))
    return found


def plot_live(rest: FloatImage, light: FloatImage, target: Path) -> None:
    """Mean grey level of each channel while a flashlight goes on and off, locked and live."""
    import matplotlib as mpl

    mpl.use("agg")
    from matplotlib.figure import Figure

    lights = [rest] * 10 + [light] * 50 + [rest] * 60
    figure = Figure(figsize=(9, 3.2), layout="constrained")
    axes = figure.subplots(1, 3, sharey=True)
    cases = {
        "locked": None,
        "live exposure": LiveExposure(white_balance=False),
        "live exposure and white balance": LiveExposure(),
    }
    for axis, (name, live) in zip(axes, cases.items(), strict=True):
        camera = load_scene("rest").rig.camera.model_copy(update={"live": live, "exposure_grey": 60.0})
        means = np.array([frame.mean((0, 1)) for frame in taken(camera, lights, rest)])
        for channel, colour in enumerate(("tab:red", "tab:green", "tab:blue")):
            axis.plot(means[:, channel], color=colour)
        axis.axvspan(10, 60, color="0.92")
        axis.set_title(name, fontsize=9)
        axis.set_xlabel("frame")
    axes[0].set_ylabel("mean grey level")
    figure.savefig(target, dpi=110)


def main() -> None:
    """Renders, films and draws."""
    rest, sensor = rendered("rest")
    room = room_radiance(sensor, sensor.radiance(UNTOUCHED, sensor.rest))
    assert room is not None
    ball, moved = (rendered("near", f"keyframes=[{{frame=0,gap_mm=1,x_mm={x}}}]")[0] for x in (-1.5, 1.5))
    sheet(effects(rest, room, ball, moved)).save(HERE / "camera-effects.png", optimize=True)
    light, _ = rendered("flashlight")
    plot_live(rest, light, HERE / "camera-live.png")


if __name__ == "__main__":
    main()
