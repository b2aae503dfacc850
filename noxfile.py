"""Everything that has to hold, each in a fresh environment: `nox`, or `nox -s docs` for one of them."""

import shutil
from pathlib import Path

import nox

nox.options.default_venv_backend = "venv"
PYTHONS = ["3.11", "3.12", "3.13", "3.14"]
PLATFORMS = ("x86_64-manylinux_2_28", "aarch64-manylinux_2_28", "aarch64-apple-darwin", "x86_64-pc-windows-msvc")
nox.options.sessions = ["tests", "experiments", "types", "detectors_only", "wheel", "docs"]
DETECTORS_ONLY = ("numpy", "opencv-contrib-python-headless")


@nox.session(python=PYTHONS)
def tests(session: nox.Session) -> None:
    """The default tests on every Python; `nox -s tests-3.12` for one, `-- -m slow` for the long ones."""
    session.install("-e", ".[test]")
    session.run("pytest", *session.posargs)


@nox.session
def experiments(session: nox.Session) -> None:
    """The tests of the experiments, which the default ones leave out."""
    session.install("-e", ".[test]", "-e", "./benchmarks/experiments[test]")
    session.run("pytest", "benchmarks/experiments/tests", *session.posargs)


@nox.session
def browser(session: nox.Session) -> None:
    """Every page in a real browser, which the machine has to have: Chromium or Chrome."""
    session.install("-e", ".[test,browser]")
    session.run("pytest", "-m", "browser", *session.posargs)


@nox.session
def learner(session: nox.Session) -> None:
    """The environment under Stable-Baselines3, for 64 steps."""
    session.install("-e", ".[test]", "stable-baselines3>=2.7", "torch>=2.7")
    session.run("pytest", "-m", "slow", "tests/unit/robot/test_learner.py")


@nox.session
def types(session: nox.Session) -> None:
    """Lint, format, types and contracts of imports."""
    session.install("-e", ".[test,dev]", "-e", "./benchmarks/experiments[test]")
    session.run("ruff", "check")
    session.run("ruff", "format", "--check")
    session.run("mypy")
    session.run("lint-imports")


@nox.session
def detectors_only(session: nox.Session) -> None:
    """The detectors where nothing but NumPy and OpenCV is installed."""
    session.install(*DETECTORS_ONLY)
    session.install("--no-deps", ".")
    folder = session.create_tmp()
    with session.chdir(folder):
        session.run("python", "-m", "magicsim.detectors", "--help", silent=True)
        session.run("python", "-c", "import magicsim.detectors as d; print(d.load_profile('calibrated'))")


@nox.session
def wheel(session: nox.Session) -> None:
    """The wheel, installed away from the checkout."""
    session.install("build")
    out = Path(session.create_tmp()).resolve()
    session.run("python", "-m", "build", "--wheel", "--outdir", str(out))
    session.install(*[str(path) for path in out.glob("magicsim-*.whl")])
    with session.chdir(out):
        session.run("magicsim", "info", "doctor")
        session.run("magicsim", "simulate", "plan", "demo", "--json", silent=True)


@nox.session
def platforms(session: nox.Session) -> None:
    """Wheels for everything that the program needs, on every system and Python that it names."""
    session.install("uv")
    options = ("--only-binary", ":all:", "--quiet", "--output-file", f"{session.create_tmp()}/resolved.txt")
    for system in PLATFORMS:
        for version in PYTHONS:
            chosen = ("--python-platform", system, "--python-version", version)
            session.run("uv", "pip", "compile", "pyproject.toml", *chosen, *options)


@nox.session(python="3.11")
def learn(session: nox.Session) -> None:
    """What needs PyTorch: a training loop's reader, models, and every study that learns in a form of minutes.

    `pip install torch` chooses the wheels, for a CPU or a GPU.
    """
    session.install("-e", ".[test,torch]", "-e", "./benchmarks/experiments[test,learn]")
    session.run("pytest", "tests/unit/dataset/test_frames.py", *session.posargs)
    session.run("pytest", "benchmarks/experiments/tests", *session.posargs)


@nox.session(python="3.12")
def lerobot(session: nox.Session) -> None:
    """An export to LeRobot's layout, opened by `lerobot` itself, in an environment of its own."""
    folder = Path(session.create_tmp()).resolve()
    shutil.rmtree(folder / "export", ignore_errors=True)
    session.install("-e", ".[test]")
    session.run("python", "tests/lerobot/write_export.py", str(folder / "export"))
    session.run("python", "-m", "venv", str(folder / "reader"))
    reader = str(folder / "reader" / "bin" / "python")
    session.run(reader, "-m", "pip", "install", "--quiet", "lerobot[dataset]>=0.6", external=True)
    session.run(reader, "tests/lerobot/read_export.py", str(folder / "export"), external=True)


@nox.session
def docs(session: nox.Session) -> None:
    """The documentation, with warnings as errors; it ends in build/docs."""
    session.install("-e", ".[docs]")
    session.run("sphinx-build", "-W", "--keep-going", "-b", "html", "docs", "build/docs", *session.posargs)


FIGURES = (
    "python benchmarks/deform.py --out docs/benchmarks",
    "python benchmarks/stress.py --out docs/benchmarks",
    "python benchmarks/cost.py --out docs/benchmarks",
    "python benchmarks/render.py --out docs/benchmarks",
    "python benchmarks/light.py left-out --out docs/benchmarks",
    "python docs/pictures.py",
    "python docs/camera_pictures.py",
    "python docs/preset_pictures.py",
    "python docs/rooms.py",
    "python docs/room_pictures.py",
    "python docs/live_pictures.py",
    "python benchmarks/experiments/docs/companions.py",
    "python benchmarks/control_loop.py --out docs/benchmarks/control-loop.json",
    "python benchmarks/control_loop.py --tier fast --out docs/benchmarks/control-loop-fast.json",
    "python benchmarks/contact_tell.py --out docs/benchmarks/contact-tell.json --cases 6",
    "python benchmarks/frame_error.py --out docs/benchmarks/frame-error.json --objects ball --images 6",
    "python benchmarks/frame_error.py --out docs/benchmarks/frame-error-objects.json --objects punch,box,cylinder "
    "--images 2 --depths 0.3,0.6,1,2",
    "python benchmarks/frame_error.py --out docs/benchmarks/tiers.json --tiers true,control,fast --objects ball,box "
    "--depths 0.1,0.5,1,2 --images 4",
    "python benchmarks/tier_verdicts.py build/tier-verdicts --out docs/benchmarks/tier-verdicts.json",
    "python benchmarks/touch_light.py --draws 2 --out docs/benchmarks/touch-light.json",
    "python benchmarks/face_facets.py --out docs/benchmarks/face-facets.json",
    "python benchmarks/default_lattice.py --out docs/benchmarks/default-lattice.json",
    "python benchmarks/wall_buckling.py",
    "python benchmarks/rungs.py docs/benchmarks/bench-stress.json --out docs/benchmarks/rungs.json",
    "python benchmarks/overlap.py --count 2000 --out docs/benchmarks/overlap.json",
    "python docs/examples/own_sensor.py",
    "python docs/examples/domed_sensor.py",
    "python benchmarks/predictions.py --cases {work}/predictions",
    "magicsim simulate demo --out {work}/demo",
    "python benchmarks/detector_options.py {work}/demo --out docs",
    "python benchmarks/operating_point.py search {work}/search.jsonl --steps 96 --first 48",
    "python benchmarks/operating_point.py check {work}/search.jsonl",
    "python benchmarks/operating_point.py report {work}/search.jsonl --out docs",
    "magicsim dataset docs/examples/learn-touch.toml --out {work}/touches --set rig.camera.columns=48"
    " --set rig.camera.rows=64 --set rig.camera.field_mm=10.8 --set design.footprint_mm=[12,16]"
    " --set design.lattice.spacing_mm=1.5 --set design.lattice.cells_across=0",
    "python docs/examples/learn_touch.py {work}/touches --figures docs/benchmarks/learn-touch.json"
    " --plot docs/benchmarks/learn-touch.png",
)
"""What the committed pictures, tables and JSON files come from; `{work}` is a folder that may go afterwards."""


@nox.session
def figures(session: nox.Session) -> None:
    """Every committed figure anew, which takes many hours: `nox -s figures`, or `-- WORD` for some."""
    session.install("-e", ".[test,reference,video,browser]")
    work = session.create_tmp()
    for command in FIGURES:
        if any(word in command for word in session.posargs) or not session.posargs:
            session.run("sh", "-c", command.format(work=work), external=True)
