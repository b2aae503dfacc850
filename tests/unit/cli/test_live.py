"""What `magicsim live` refuses before a page is opened."""

from pathlib import Path

import pytest

from magicsim.cli.app import app
from magicsim.errors import ConfigError, OutputError, PresetError


@pytest.mark.parametrize("port", ["80", "99999"])
def test_port_outside_of_the_range_is_refused(port: str):
    with pytest.raises(ConfigError, match=rf"port = {port} is not allowed: must be 1024 to 65000"):
        app(["live", "pressed", "--port", port], exit_on_error=False)


def test_unknown_subject_names_what_there_is():
    with pytest.raises(PresetError, match=r"unknown scene or design 'nonsense'"):
        app(["live", "nonsense"], exit_on_error=False)


def test_unknown_quality_names_what_there_is():
    with pytest.raises(ConfigError, match=r"unknown quality 'best'.*control"):
        app(["live", "pressed", "--quality", "best", "--no-browser"], exit_on_error=False)


@pytest.mark.parametrize("out", ["file", "file/x"])
def test_place_that_takes_no_recording_is_refused_before_the_page_is_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, out: str
):
    monkeypatch.setattr("magicsim.live.window.open_server", lambda *_: pytest.fail("opened"))
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match="file' is not a folder"):
        app(["live", "pressed", "--no-browser", "--out", str(tmp_path / out)], exit_on_error=False)
