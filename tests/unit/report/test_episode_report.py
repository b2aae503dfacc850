"""What of an episode is judged, and what is said of the rest."""

from types import SimpleNamespace

import pytest

from magicsim.errors import FrameError
from magicsim.report.episode_report import judged


def test_a_profile_that_refuses_a_sensor_keeps_no_other_from_judging(monkeypatch: pytest.MonkeyPatch):
    def judge(_: object, name: str) -> str:
        if name == "published":
            msg = "reference frames show no grid"
            raise FrameError(msg)
        return name

    monkeypatch.setattr("magicsim.report.episode_report.judge", judge)
    clear = SimpleNamespace(design=SimpleNamespace(is_opaque=False))
    seen = judged(SimpleNamespace(references=[None], scene=clear))  # type: ignore[arg-type]
    assert seen == (["calibrated"], "profile 'published': reference frames show no grid")


def test_without_references_nothing_is_judged_and_nothing_refused():
    assert judged(SimpleNamespace(references=[])) == ([], None)  # type: ignore[arg-type]
