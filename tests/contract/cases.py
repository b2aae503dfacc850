"""What users rely on, made through the command line and the public names alone: frames, forces, JSON keys."""

import hashlib
import json
import platform
import subprocess
import sys
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
LIBRARIES = ("mitsuba", "drjit", "numba", "numpy", "scipy", "manifold3d", "opencv-contrib-python-headless")
SMALL = (
    "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=1.2", "rig.camera.columns=24", "rig.camera.rows=32",
    "rig.camera.field_mm=10", "render.samples=2", "render.particles=2000", "render.anchor_samples=2",
    "render.anchor_particles=2000",
)  # fmt: skip
PRESETS = (
    "mini-magictac-finger", "gelsight-type", "gelsight-type-markers", "marker-type", "see-through-markers",
    "translucent-9dtact",
)  # fmt: skip
PRESSED = (
    "object={kind='box',size_mm=[4.0,6.0,4.0],edge_radius_mm=0.3,yaw_deg=25.0,color=[0.85,0.45,0.15]}",
    "keyframes=[{frame=0},{frame=1,gap_mm=-0.6}]", "references=0", "render.samples=2", "render.particles=20000",
    "render.anchor_samples=0", "rig.camera.columns=48", "rig.camera.rows=60",
)  # fmt: skip
BLOCK = (
    "footprint_mm=[12.0,12.0]", "skin_mm=1.0", "core_mm=4.0", "cell_mm=0.8", "wall_mm=0.2", "lattice.spacing_mm=1.0",
)  # fmt: skip


def processor() -> dict[str, str]:
    """What bytes depend on beside the program: the instructions that machine code is compiled for, and libraries."""
    from llvmlite import binding

    features = hashlib.sha256(binding.get_host_cpu_features().flatten().encode()).hexdigest()[:16]
    name = f"{platform.machine()} {binding.get_host_cpu_name()} {features}"
    return {"processor": name, "libraries": " ".join(f"{each} {version(each)}" for each in LIBRARIES)}


def run(*words: str, folder: Path) -> str:
    """Standard output of a command."""
    done = subprocess.run(
        [sys.executable, "-m", "magicsim", *words], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"magicsim {' '.join(words)}: {done.stderr}"
    return done.stdout


def put(*settings: str) -> list[str]:
    """Settings as words of a command line."""
    return [word for each in settings for word in ("--set", each)]


def _written(folder: Path, *words: str) -> dict[str, str]:
    """Digests of the PNG files that a command writes, by their names."""
    run(*words, "--out", "run", *put("output.report=false", "output.preview=false"), folder=folder)
    return {path.name: _digest(path.read_bytes()) for path in sorted((folder / "run" / "frames").glob("*.png"))}


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _images(*images: np.ndarray) -> dict[str, str]:
    return {str(number): _digest(np.ascontiguousarray(each).tobytes()) for number, each in enumerate(images)}


def _preset(name: str) -> Callable[[Path], dict[str, str]]:
    def frames(_: Path) -> dict[str, str]:
        from magicsim import load_scene, simulate

        return _images(*(each.image for each in simulate(load_scene(name, list(PRESSED))).frames))

    return frames


def two_fingers(_: Path) -> dict[str, str]:
    """One frame of a finger that another one faces at 12 mm."""
    from magicsim.robot import Workspace, live_sensor

    space = Workspace(x_mm=(0, 0), y_mm=(0, 0), twist_deg=(0, 0), gap_mm=(-1, 30))
    with live_sensor("grip", workspace=space) as sensor:
        sensor.face(12.0)
        return _images(sensor.frame().image)


def passing(_: Path) -> dict[str, str]:
    """Three frames while a person crosses what the sensor looks at, which changes each of them."""
    from magicsim import load_scene, simulate

    scene = [
        "rig.camera.columns=60", "rig.camera.rows=80", "references=0", "render.samples=2", "render.particles=20000",
        "rig.room='corridor'", "frames_per_second=2", "keyframes=[{frame=0,gap_mm=20.0},{frame=2,gap_mm=20.0}]",
    ]  # fmt: skip
    frames = [
        _images(*(each.image for each in simulate(load_scene("near", [*scene, *more], seed=3)).frames))
        for more in (["rig.passing.every_s=3600"], ["rig.passing={size_mm=[2000.0,4000.0],every_s=2.5}"])
    ]
    assert frames[0] != frames[1], "nothing passes"
    return frames[1]


FRAMES: dict[str, Callable[[Path], Mapping[str, str]]] = {
    "demo --seed 1": lambda folder: _written(folder, "demo", "--seed", "1"),
    "simulate pressed --seed 7": lambda folder: _written(folder, "simulate", "pressed", "--seed", "7"),
    "two fingers": two_fingers,
    "passing": passing,
    **{f"preset {name}": _preset(name) for name in PRESETS},
}
"""Digests of frames of each case, which takes an empty folder."""


def paths() -> list[tuple[str, list[str], dict[str, object]]]:
    """Twenty stress paths: object, settings of the block, options of `press`."""
    stiff = [f"materials.infill.shear_modulus_mpa={0.369 / contrast:.9g}" for contrast in (1.0, 1e2, 1e4, 3e5)]
    found: list[tuple[str, list[str], dict[str, object]]] = [
        ("sphere:radius_mm=4", [each], {"depth_mm": 1.8}) for each in stiff
    ]
    found += [
        ("sphere:radius_mm=4", [f"materials.body.poisson_ratio={ratio}"], {"depth_mm": 1.8})
        for ratio in (0.25, 0.45, 0.4999, 0.499999)
    ]
    found += [
        (thing, [], {"depth_mm": 1.2})
        for thing in (
            "sphere:radius_mm=0.5", "domed_cylinder:radius_mm=0.5", "cone:half_angle_deg=30", "punch:radius_mm=0.5",
            "dots:radius_mm=0.2,spacing_mm=0.8", "box:size_mm=4x4x8", "cylinder:radius_mm=2,length_mm=8,axis=y",
        )
    ]  # fmt: skip
    found += [
        ("sphere:radius_mm=4", [], {"depth_mm": 1.0, "friction": 0.5, "shear_mm": (0.6, -0.3)}),
        ("sphere:radius_mm=4", [], {"depth_mm": 1.0, "friction": 1.0, "twist_deg": 20.0}),
        ("box:size_mm=4x4x8", [], {"depth_mm": 0.8, "friction": 1.0, "shear_mm": (0.5, 0.0), "twist_deg": 10.0}),
        ("sphere:radius_mm=4", [], {"depth_mm": 3.0}),
        ("sphere:radius_mm=4", ["materials.body.prony=[{time_s=0.03,modulus_mpa=2.0},{time_s=1.0,modulus_mpa=0.5}]"],
         {"depth_mm": 1.0, "speed_mm_s": 1.0, "hold_s": 0.5}),
    ]  # fmt: skip
    return found


def forces() -> dict[str, list[float]]:
    """Force [N], torque [N mm] and contact area [mm2] of each stress path."""
    from magicsim import load_design, load_object, press

    found = {}
    for thing, settings, options in paths():
        design = load_design("mini-magictac", [*BLOCK, *settings])
        pressed = press(design, load_object(thing), told=lambda _: None, **options)
        name = " ".join([thing, *settings, *(f"{key}={value}" for key, value in options.items())])
        found[name] = [*pressed.force_n, *pressed.torque_nmm, pressed.contact_area_mm2]
    return found


COMMANDS: dict[str, list[str]] = {
    "simulate": ["simulate", "near", "--out", "run", *put(*SMALL, "references=30")],
    "demo": ["demo", "--out", "demo", *put(*SMALL)],
    "plan": ["plan", "demo"],
    "press": ["press", "uniform-block", "--object", "sphere:radius_mm=4", "--depth-mm", "0.3"],
    "durometer": ["durometer", "uniform-block", *put("footprint_mm=[12,12]", "lattice.spacing_mm=1.5")],
    "render": ["render", "near", "--out", "one.npy", *put(*SMALL)],
    "calibration": ["calibration", "rest"],
    "detect": ["detect", "run"],
    "evaluate": ["evaluate", "--on", "run"],
    "fit": ["fit", "run/frames", "--out", "mine.toml", "--starts", "1", "--evaluations", "1",
            *put(*SMALL, "references=30")],
    "calibrate": ["calibrate", "demo", "--out", "profile.toml"],
    "dataset": ["dataset", "default", "--out", "set", "--workers", "1",
                *put(*SMALL[:5], "episodes=1", "references=1", *SMALL[5:])],
    "dataset verify": ["dataset", "verify", "set"],
    "dataset export": ["dataset", "export", "set", "--format", "webdataset", "--out", "tars"],
    "sweep": ["sweep", "cell-skin", "--out", "swept", "--workers", "1", *put(
        "swept=[{field='design.skin_mm',values=[0.5,2.0]}]", "also=[]", "objectives=[{measure='printability'}]",
        "design.lattice.spacing_mm=1.5",
        "quality={columns=48,rows=64,samples=2,particles=4000,anchor_samples=4,anchor_particles=20000,draws=4,"
        "gaps_mm=[20.0,5.0,1.0],depths_mm=[0.1,0.3,1.0],touches=6,line_spacings_mm=[2.0],dot_spacings_mm=[2.0]}")],
    "export": ["export", "mini-magictac", "--out", "part.glb", *put("footprint_mm=[10,10]")],
    "list": ["list"],
    "doctor": ["doctor"],
    "schema": ["schema", "scene"],
    "real": ["real", "recording.toml", "--out", "recorded"],
}  # fmt: skip
"""Words of each command, in an order in which later ones find what earlier ones wrote."""


def keys(value: object) -> object:
    """Keys of a JSON value; of a list those of its first item, of everything else what it is."""
    if isinstance(value, dict):
        return {name: keys(each) for name, each in value.items()}
    if isinstance(value, list):
        return [keys(value[0])] if value and isinstance(value[0], dict) else "list"
    return "number" if isinstance(value, int | float) and not isinstance(value, bool) else type(value).__name__


def write_recording(folder: Path) -> None:
    """A description of the frames of a run, as a recording of a sensor."""
    lines = ["schema_version = 1", "[[recordings]]", 'frames = "run/frames"', "untouched_first = 30", ""]
    (folder / "recording.toml").write_text("\n".join(lines), encoding="utf-8")


def printed_keys(command: str, folder: Path) -> object:
    """Keys of what a command prints with `--json`."""
    return keys(json.loads(run(*COMMANDS[command], "--json", folder=folder)))
