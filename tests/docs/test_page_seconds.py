"""The build says what executed pages took, and a slow one is a warning."""

import logging
import sys
from types import SimpleNamespace

import pytest

from .pages import DOCS

pytest.importorskip("myst_nb")


def test_page_over_two_minutes_is_a_warning_and_others_are_told(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
):
    monkeypatch.syspath_prepend(str(DOCS / "_ext"))
    import page_seconds

    monkeypatch.setattr(page_seconds, "LOGGER", logging.getLogger("page_seconds"))
    monkeypatch.setattr(page_seconds.os, "getloadavg", lambda: (load, 0, 0))
    load = 0.5
    times = {"notebooks/slow": {"exec_data": {"runtime": 121.0}}, "notebooks/quick": {"exec_data": {"runtime": 31.4}}}
    pages = {**times, "index": {}, "notebooks/cached": {"exec_data": {"runtime": None}}}
    told = []
    monkeypatch.setattr(page_seconds.LOGGER, "warning", lambda words, *at, **more: told.append((words % at, more)))
    with caplog.at_level(logging.INFO, "page_seconds"):
        page_seconds.tell(SimpleNamespace(), SimpleNamespace(nb_metadata=pages))
    assert caplog.messages == ["notebooks/quick took 31 s"]
    assert told == [("took 121 s: must be at most 120 s", {"location": "notebooks/slow", "type": "page_seconds"})]
    load, told[:] = 1e4, []
    caplog.clear()
    with caplog.at_level(logging.INFO, "page_seconds"):
        page_seconds.tell(SimpleNamespace(), SimpleNamespace(nb_metadata=pages))
    assert caplog.messages[-1] == "notebooks/slow took 121 s beside other work"
    assert told == []
    monkeypatch.delitem(sys.modules, "page_seconds")
