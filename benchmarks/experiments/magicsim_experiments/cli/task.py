"""The commands that play a task of the gripper: `task grasp`, `task assembly` and `task alignment`."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, Threads, fields_of, limit_threads, print_result
from magicsim.errors import ConfigError

task_app = App(name="task", help="Play a task with two sensors on a gripper.")
MOST_EPISODES = 100_000


@task_app.command
def grasp(
    *, out: Out,
    episodes: Annotated[int, Parameter(help="How many; with --resume a finished folder grows by more.")] = 50,
    detector: Annotated[str, Parameter(help="Profile: calibrated, facing, published or a file.")] = "calibrated",
    room: Annotated[str, Parameter(help="office, window, bench, corridor, dark, or an image.")] = "office",
    quality: Annotated[Literal["full", "control"], Parameter(help="How finely is solved and rendered.")] = "full",
    resume: Annotated[bool, Parameter(negative="", help="Go on with the folder's run.")] = False,
    film: Annotated[bool, Parameter(negative="", help="Keep a film and a contact sheet of each episode.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Grasp and carry: the published machine reads rendered frames and drives gripper and carriage from A to B.

    Each episode draws an item, how a hand offers it, a pull, flashlights. --set changes settings, such as
    `items=["orange"]` or `grip_n=6`.
    """
    if not 1 <= episodes <= MOST_EPISODES:
        raise ConfigError(f"--episodes {episodes} is not allowed: must be 1 to {MOST_EPISODES}")
    from magicsim.config.models import apply_overrides, validate
    from magicsim_experiments.task.growing import FOLDER
    from magicsim_experiments.task.settings import GraspConfig

    asked = {"detector": detector, "room": room, "quality": quality} | ({} if seed is None else {"seed": seed})
    config = validate(GraspConfig, apply_overrides(asked, settings or []), source="task grasp")
    FOLDER.check(out, resume=resume)
    from magicsim.cli.progress import show_progress
    from magicsim_experiments.task.running import run_grasps

    with show_progress("task grasp") as progress:
        summary = run_grasps(config, out, episodes=episodes, resume=resume, with_film=film, progress=progress)
    print_result(fields_of(summary), as_json=json)


@task_app.command
def assembly(
    scene: str = "assembly", *, out: Out,
    trials: Annotated[int, Parameter(help="How many, by thirds beside, at an angle, aligned; --resume adds.")] = 16,
    quality: Annotated[str, Parameter(help="control, or full: slower and finer.")] = "control",
    samples: Annotated[int, Parameter(help="Pairs of frames of each stage, 1 to 20.")] = 1,
    base: Annotated[bool, Parameter(help="Whether the base is in the picture.")] = True,
    resume: Annotated[bool, Parameter(negative="", help="Go on with the folder's run.")] = False,
    settings: Settings = None, seed: Seed = None, threads: Threads = None, json: Json = False,
) -> None:  # fmt: skip
    """Plug a held plug into a base in six stages, and tell who notices that the base is misaligned.

    --set changes the scene, or the task where its key begins with `task.`, such as `task.jack.radius_mm=2.8` or
    `task.offset_mm=[1,3]`.
    """
    from magicsim.scenes.scene import load_scene
    from magicsim_experiments.assembly.stages import split_settings
    from magicsim_experiments.task.growing import FOLDER

    for_scene, config = split_settings(settings or [])
    loaded = load_scene(scene, for_scene, seed=seed)
    FOLDER.check(out, resume=resume)
    limit_threads(threads)
    from magicsim.cli.progress import show_progress
    from magicsim_experiments.assembly.running import run_assembly

    with show_progress("task assembly") as progress:
        summary = run_assembly(
            loaded, out, trials=trials, seed=loaded.seed, quality=quality, samples=samples, shows_base=base,
            config=config, resume=resume, progress=progress,
        )  # fmt: skip
    print_result(fields_of(summary), as_json=json)


@task_app.command
def alignment(
    *, out: Out,
    model: Annotated[Path | None, Parameter(help="File model.safetensors of the study alignment.")] = None,
    episodes: Annotated[int, Parameter(help="How many; with --resume a finished folder grows by more.")] = 14,
    quality: Annotated[Literal["full", "control"], Parameter(help="How finely is solved and rendered.")] = "full",
    resume: Annotated[bool, Parameter(negative="", help="Go on with the folder's run.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Hold a cylinder askew, read its angle from both fingers with a learned model, and turn it upright with the wrist.

    Items take turns, a pen that the model has not seen among them. --set changes settings, such as `items=["pen"]` or
    `grip_n=4`.
    """
    if not 1 <= episodes <= MOST_EPISODES:
        raise ConfigError(f"--episodes {episodes} is not allowed: must be 1 to {MOST_EPISODES}")
    from magicsim.config.models import apply_overrides, validate
    from magicsim_experiments.learn.settings import PACKAGES, need_packages
    from magicsim_experiments.task.alignment.grip import MISSING_MODEL, AlignmentConfig
    from magicsim_experiments.task.growing import FOLDER

    if model is None:
        raise ConfigError(MISSING_MODEL)
    asked = {"quality": quality} | ({} if seed is None else {"seed": seed})
    config = validate(AlignmentConfig, apply_overrides(asked, settings or []), source="task alignment")
    need_packages(PACKAGES, "task alignment")
    FOLDER.check(out, resume=resume)
    from magicsim.cli.progress import show_progress
    from magicsim_experiments.task.alignment.running import run_alignment

    with show_progress("task alignment") as progress:
        summary = run_alignment(config, model, out, episodes=episodes, resume=resume, progress=progress)
    print_result(fields_of(summary), as_json=json)
