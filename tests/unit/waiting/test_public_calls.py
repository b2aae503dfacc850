"""Public functions that may take long say so, once, and only where nothing else does."""

import inspect
from pathlib import Path
from types import SimpleNamespace

import pytest

import magicsim
import magicsim.waiting as module
from magicsim.cli.progress import show_progress
from magicsim.geometry.design import load_design
from magicsim.geometry.objects.kinds import parse_object
from magicsim.scenes.scene import load_scene
from magicsim.simulation import still, stream
from magicsim.waiting import on_stderr, waiting
from magicsim.workers.attempt import attempt

QUICK = {"calibrate_camera", "export_design", "plan_scene", "relight"}
"""Names that are done at once, and the sensor, which is built and asked for single states."""
SPOKEN = sorted(
    name for name in magicsim.__all__ if name[0].islower() and not name.startswith("load_") and name not in QUICK
)


@pytest.fixture
def lines(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Lines that were told, which begin at once."""
    monkeypatch.setattr(module, "FIRST_S", 0.0)
    monkeypatch.setattr(module, "NEXT_S", 0.01)
    return []


def heard(lines: list[str]) -> str:
    """The next line."""
    count = len(lines)
    while len(lines) == count:
        module.time.sleep(0.005)
    return lines[-1]


@pytest.mark.parametrize("name", SPOKEN)
def test_function_that_may_take_long_takes_who_hears_it_and_says_so(name: str):
    function = getattr(magicsim, name)
    assert inspect.signature(function).parameters["told"].default is on_stderr
    assert "told: " in inspect.getdoc(function)


def test_episode_tells_its_share_unless_its_caller_is_told(lines: list[str], monkeypatch: pytest.MonkeyPatch):
    def simulated(sensor: object, plan: object, *, progress: stream.Progress) -> str:
        progress(1, 4)
        if not told_by_caller:
            assert heard(lines).startswith("simulating (25%), ")
        return "episode"

    told_by_caller: list[tuple[int, int]] = []
    monkeypatch.setattr(stream, "simulate_with", simulated)
    monkeypatch.setattr(stream, "Sensor", SimpleNamespace(for_scene=lambda scene: None))
    assert magicsim.simulate(load_scene("rest"), told=lines.append) == "episode"
    lines.clear()
    told_by_caller.append((0, 0))
    magicsim.simulate(load_scene("rest"), told=lines.append, progress=lambda *now: told_by_caller.append(now))
    assert (lines, told_by_caller) == ([], [(0, 0), (1, 4)])


def test_still_says_which_frame(lines: list[str], monkeypatch: pytest.MonkeyPatch):
    def build(scene: object) -> None:
        raise KeyError(heard(lines))

    monkeypatch.setattr(still, "Sensor", SimpleNamespace(for_scene=build))
    with pytest.raises(KeyError, match="rendering frame 0, "):
        magicsim.render(load_scene("pressed"), told=lines.append)


def test_press_tells_its_share_on_stderr_and_under_a_bar_nothing(lines: list[str], capsys: pytest.CaptureFixture[str]):
    block = load_design("uniform-block", ["footprint_mm=[12,16]", "lattice.spacing_mm=2"])
    ball = parse_object("sphere:radius_mm=4")
    magicsim.press(block, ball, depth_mm=0.5)
    said = capsys.readouterr().err
    assert said.startswith("magicsim: pressing")
    with show_progress("press"):
        magicsim.press(block, ball, depth_mm=0.5)
    assert "magicsim:" not in capsys.readouterr().err


def test_task_of_a_worker_is_silent(lines: list[str]):
    def work(_: object) -> int:
        with waiting("pressing", lines.append):
            return len(lines)

    assert attempt(work, None, None, 1).result == 0
    assert lines == []


def test_profile_fit_says_so(lines: list[str], tmp_path: Path):
    def read(folder: Path) -> list[object]:
        raise KeyError(heard(lines))

    with pytest.raises(KeyError, match="fitting a profile, "):
        magicsim.calibrate([tmp_path], tmp_path / "mine.toml", read=read, told=lines.append)
