"""Every public name of the package, each in the job it is for.

python docs/examples/whole_api.py OUT      # presses, simulates, renders, prints and fits; half an hour
"""

import sys
from pathlib import Path

import magicsim
from magicsim.fit.observation import observe

BLOCK, RIG, BALL = "mini-magictac", "digit-office", "sphere:radius_mm=4"


def press(settings: list[str]) -> float:
    """Force of a ball 1 mm deep in the block [N]."""
    pressed = magicsim.press(magicsim.load_design(BLOCK, settings), magicsim.load_object(BALL), depth_mm=1.0)
    print(pressed)
    return pressed.force_n[2]


def press_deeper_and_deeper(settings: list[str]) -> list[float]:
    """Force at half a millimetre and at one, the path solved once [N]."""
    block, ball = magicsim.load_design(BLOCK, settings), magicsim.load_object(BALL)
    return [point[2] for point in magicsim.press_curve(block, ball, [0.5, 1.0]).forces_n]


def press_until_it_fails(settings: list[str]) -> float | None:
    """Depth at which something of the block fails first, every strength at its lowest [mm]."""
    dome = magicsim.load_object("domed_cylinder:radius_mm=1")
    return magicsim.press_limits(magicsim.load_design(BLOCK, settings), dome).as_dict()["recommended_depth_mm"]


def harden(settings: list[str]) -> float:
    """Shore A hardness of the block."""
    return magicsim.durometer(magicsim.load_design(BLOCK, settings)).shore_a


def print_and_calibrate(out: Path, settings: list[str]) -> tuple[float, float]:
    """Volume of the printed walls and skin [mm3], and millimetres a pixel on the face."""
    block, rig = magicsim.load_design(BLOCK, settings), magicsim.load_rig(RIG)
    layers = magicsim.calibrate_camera(block, rig).layers
    return magicsim.export_design(block, out / "block.3mf").volume_mm3, layers[0].mm_per_pixel[0]


def simulate_and_judge(out: Path, settings: list[str]) -> tuple[int, float | None]:
    """Frames of a whole run, and how many of its contacts `calibrated` finds; the episode is saved beside."""
    scene = magicsim.load_scene("demo", settings)
    print(len(magicsim.plan_scene(scene).frames), "frames are planned")
    episode = magicsim.simulate(scene)
    print(episode)
    episode.save(out / "episode.npz")
    judged = magicsim.judge_episode(episode, "calibrated")
    return len(episode.images), judged.score.contact.accuracy


def render_and_film(settings: list[str]) -> tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]]:
    """Shapes of one still, of one frame of a sensor asked state by state, and of one frame of a live sensor."""
    scene = magicsim.load_scene("pressed", settings)
    still = magicsim.render(scene, 0).image
    state = magicsim.plan_scene(scene).frames[0].state
    sensor = magicsim.Sensor(scene.design, scene.rig, scene.object, render=scene.render, states=[state])
    radiance = sensor.radiance(state, sensor.deform(state, sensor.rest))
    live = magicsim.live_sensor("pressed", settings)
    live.move_to(gap_mm=2.0)
    return still.shape, radiance.shape, live.frame().image.shape


def detect_and_fit(out: Path, settings: list[str]) -> tuple[str, str]:
    """Verdict on the last frame of a run, read as images of a real sensor are; the profile fitted to the run."""
    magicsim.run_scene(magicsim.load_scene("demo", settings), out / "demo")
    frames = sorted((out / "demo" / "frames").glob("*.png"))
    print(magicsim.load_profile("published").tau_g)
    verdicts = magicsim.detect(frames[-1], out / "demo" / "frames", "published")
    return verdicts[-1].contact, magicsim.calibrate([out / "demo"], out / "mine.toml").profile


def fit_a_sensor(out: Path, settings: list[str]) -> float:
    """What is left of the difference when constants are fitted to images of a sensor [grey levels, rms]."""
    scene = magicsim.load_scene("rest", settings)
    images = [frame.image for frame in magicsim.simulate(scene).references]
    shown = observe(images, scene.rig.camera)
    free, few = ["infill_scattering"], {"blocks": (5, 4), "starts": 1, "evaluations": 2}
    return magicsim.fit_constants(scene, [shown], out / "fitted.toml", free=free, **few).rms


def compare_and_collect(out: Path, recipe: list[str], sweep: list[str], suite: list[str]) -> tuple[int, int, int]:
    """Rows of a dataset, designs of a sweep, and takes that a detector was judged on."""
    made = magicsim.make_dataset(magicsim.load_recipe("default", recipe), out / "data")
    swept = magicsim.run_sweep(magicsim.load_sweep("cell-skin", sweep), out / "sweep")
    judged = magicsim.evaluate(magicsim.load_suite("small", suite), "calibrated", cache=out / "takes")
    return made.samples, swept.designs, len(judged.episodes)


def main(out: Path) -> None:
    """Everything at full size, except for what takes hours."""
    out.mkdir(parents=True, exist_ok=True)
    print(
        press([]),
        press_deeper_and_deeper([]),
        press_until_it_fails([]),
        harden([]),
        print_and_calibrate(out, []),
        simulate_and_judge(out, []),
        render_and_film([]),
    )
    print(detect_and_fit(out, []), fit_a_sensor(out, []), compare_and_collect(out, [], [], []))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
