import subprocess
import sys

PAGE = ("magicsim.report.page", "magicsim.report.animation.preview")


def _loaded(modules: tuple[str, ...], watched: set[str]) -> str:
    code = f"import sys, {', '.join(modules)}; print(*sorted({watched!r} & set(sys.modules)))"
    return subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.strip()


def test_package_itself_loads_nothing_heavy():
    assert _loaded(("magicsim.report",), {"matplotlib", "jinja2", "PIL", "numpy", "mitsuba"}) == ""


def test_page_needs_neither_pyplot_nor_the_renderer():
    assert _loaded(PAGE, {"matplotlib.pyplot", "mitsuba", "drjit"}) == ""
