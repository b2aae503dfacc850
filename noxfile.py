"""Everything that has to hold, each in a fresh environment: `nox`, or `nox -s docs` for one of them."""

from pathlib import Path

import nox

nox.options.default_venv_backend = "venv"
DETECTORS_ONLY = ("numpy", "opencv-contrib-python-headless")


@nox.session
def tests(session: nox.Session) -> None:
    """The default tests; `nox -s tests -- -m slow` for the long ones."""
    session.install("-e", ".[test]")
    session.run("pytest", *session.posargs)


@nox.session
def types(session: nox.Session) -> None:
    """Lint, format and types."""
    session.install("-e", ".[test,dev]")
    session.run("ruff", "check")
    session.run("ruff", "format", "--check")
    session.run("mypy")


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
        session.run("magicsim", "doctor")
        session.run("magicsim", "plan", "demo", "--json", silent=True)


@nox.session
def docs(session: nox.Session) -> None:
    """The documentation, with warnings as errors; it ends in build/docs."""
    session.install("-e", ".[docs]")
    session.run("sphinx-build", "-W", "--keep-going", "-b", "html", "docs", "build/docs", *session.posargs)
