"""Streams, widths, locales and folders that the command line finds around it."""

import io
import subprocess
import sys
from pathlib import Path

import pytest

from magicsim.cli.surroundings import WIDEST, LossyStream

from .conftest import Shell

ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "utf-8"}
PART = ["export", "uniform-block", "--set", "footprint_mm=[6,6]", "--out"]


def run(monkeypatch: pytest.MonkeyPatch, *words: str, streams: str = "") -> subprocess.CompletedProcess[str]:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[3]))
    command = ["sh", "-c", f'"$0" -m magicsim "$@" {streams}', sys.executable, *words]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=60, encoding="utf-8")


@pytest.mark.parametrize("columns", ["0", "1", "999999999", "²"])
def test_help_has_lines_of_a_bounded_width(shell: Shell, monkeypatch: pytest.MonkeyPatch, columns: str):
    monkeypatch.setenv("COLUMNS", columns)
    done = shell("simulate", "--help")
    assert done.code == 0
    assert 30 < max(map(len, done.out.splitlines())) <= WIDEST
    assert "Simulate a scene" in done.out


def test_result_on_disk_is_whole_where_all_streams_are_closed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    done = run(monkeypatch, *PART, str(tmp_path / "part.stl"), streams="<&- >&- 2>&-")
    assert (done.returncode, done.stderr) == (0, "")
    content = (tmp_path / "part.stl").read_bytes()
    assert len(content) == 84 + 50 * int.from_bytes(content[80:84], "little")  # head and triangles of a binary STL file


def test_work_goes_on_where_nobody_reads_its_progress():
    class Gone(io.StringIO):
        def write(self, _: str) -> int:
            raise BrokenPipeError

        def flush(self) -> None:
            raise BrokenPipeError

    stream = LossyStream(Gone())
    assert stream.write("10%") == 3
    stream.flush()
    assert not stream.isatty()


def test_error_has_its_exit_code_where_nobody_can_be_told(monkeypatch: pytest.MonkeyPatch):
    assert run(monkeypatch, "simulate", "plan", "nera", streams="2>&-").returncode == 2


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full device")
def test_full_disk_under_the_output_is_one_line(monkeypatch: pytest.MonkeyPatch):
    done = run(monkeypatch, "--help", streams=">/dev/full")
    assert (done.returncode, done.stderr) == (2, "magicsim: No space left on device\n")


@pytest.mark.skipif(sys.platform != "linux", reason="other systems name files in UTF-8 whatever the locale is")
def test_locale_of_ascii_does_not_matter(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    for name, value in ASCII.items():
        monkeypatch.setenv(name, value)
    done = run(monkeypatch, *PART, str(tmp_path / "größe.stl"))
    assert done.returncode == 0, done.stderr
    assert f"{tmp_path}/größe.stl" in done.stdout
    assert "unknown scene 'nöra'" in run(monkeypatch, "simulate", "plan", "nöra").stderr


def test_output_without_the_letters_of_a_text_spells_them_out(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    done = run(monkeypatch, "press", "uniform-block", "--object", "ö", "--depth-mm", "1", streams="2>&1")
    assert r"unknown object kind '\xf6'" in done.stdout


def test_name_that_is_no_text_is_refused_before_any_work(shell: Shell):
    assert "cannot write r\\udcff: no name in utf-8" in shell.refusal("simulate", "near", "--out", "r\udcff")


def test_current_folder_that_is_gone_is_one_line(shell: Shell, monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    assert "the current folder is gone" in shell.refusal(*PART, "part.stl")


def test_home_folder_that_is_missing_is_one_line(shell: Shell, monkeypatch: pytest.MonkeyPatch):
    def none(*_: object) -> None:
        raise KeyError

    monkeypatch.delenv("HOME", raising=False)
    monkeypatch.setattr("pwd.getpwuid", none)
    assert "there is no home folder" in shell.refusal("info", "completion", "bash", "--install")
    assert shell.json("info", "doctor")["frames_bytes"] == 0


def test_help_without_docstrings_says_why_it_is_short():
    done = subprocess.run(
        [sys.executable, "-OO", "-m", "magicsim", "--help"], capture_output=True, text=True, check=True
    )
    assert "Without descriptions, which Python leaves out" in " ".join(done.stdout.split())


@pytest.mark.parametrize("threads", ["0", "-1", "many", ""])
def test_number_of_threads_that_is_none_is_one_line(shell: Shell, monkeypatch: pytest.MonkeyPatch, threads: str):
    monkeypatch.setenv("NUMBA_NUM_THREADS", threads)
    line = f"NUMBA_NUM_THREADS = '{threads}' is not allowed: must be a whole number"
    assert line in shell.refusal("simulate", "plan", "near")


def test_backend_of_drawings_that_is_none_does_not_matter(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("MPLBACKEND", "garbage")
    code = (
        "from magicsim.cli.surroundings import prepare; prepare(); import matplotlib; print(matplotlib.get_backend())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip().lower() == "agg"
