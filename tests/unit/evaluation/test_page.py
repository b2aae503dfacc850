"""The report and the result's JSON."""

import base64
import io
import json
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from magicsim.evaluation.baseline import load_baseline, save_baseline
from magicsim.evaluation.evaluate import Evaluation
from magicsim.evaluation.page import describe, feature_rows, render_page
from magicsim.evaluation.pictures import sheet
from magicsim.judge.tally import FramesSeen
from magicsim.notebook.screen import EDGE_PX, to_srgb


class Page(HTMLParser):
    """Tags that are open, and addresses that a page loads."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.addresses += [value or "" for name, value in attributes if name in {"src", "href"}]
        if tag not in {"meta", "img", "br", "link"}:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_page_needs_nothing_else_and_closes_every_tag(worse: Evaluation):
    page = Page()
    page.feed(render_page(worse))
    assert page.open == []
    assert page.addresses
    assert all(address.startswith(("data:", "#")) for address in page.addresses)


def test_page_shows_every_group_and_names_the_fallen_frames(worse: Evaluation):
    text = render_page(worse)
    for group in worse.metrics:
        assert f">{group}<" in text
    assert worse.regressions
    run = worse.regressions[0].frames[0]
    assert run.episode in text
    assert "fell</span> against the baseline" in text


def test_frames_stand_beside_their_change_on_a_screen(found: Evaluation):
    film, episode = found.footage[0], found.episodes[0]
    picture = sheet([film], [episode], found.standard)[0]
    shown = np.asarray(Image.open(io.BytesIO(base64.b64decode(picture["uri"].partition(",")[2]))).convert("RGB"), float)
    frame = list(film.images.frames())[int(picture["title"].split()[-1])]
    assert shown.shape == (len(frame), 2 * frame.shape[1] + EDGE_PX, 3)
    assert shown[:, : frame.shape[1]].mean() == pytest.approx(255 * to_srgb(frame / 255).mean(), abs=4)


def test_page_without_baseline_says_so(found: Evaluation):
    text = render_page(found)
    assert "no baseline" in text
    assert "Compared with the baseline" not in text


def test_json_holds_intervals_curves_and_regressions_with_frames(worse: Evaluation):
    content = json.loads(json.dumps(worse.as_dict(), allow_nan=False))
    headline = content["metrics"][content["standard"]]["contact_balanced_accuracy"]
    assert headline["low"] <= headline["value"] <= headline["high"]
    assert headline["episodes"] == 8
    assert content["regressions"][0]["frames"][0].keys() == {
        "episode", "first", "last", "truth", "baseline", "current",
    }  # fmt: skip
    assert sum(content["confusion"]["contact"]["Near"].values()) == 8 * 4
    assert content["detection_by_distance"]
    assert content["frames"] == 16 * 25


def test_lines_for_people_name_what_fell(worse: Evaluation, found: Evaluation):
    text = "\n".join(describe(worse))
    assert "regression: Contact, balanced accuracy (dark/rig)" in text
    assert "Contact, Touched -> Untouched" in text
    assert not any("regression" in line for line in describe(found))


@pytest.mark.parametrize(
    "name", ["<script>alert(1)</script>", "</dd><img src=x onerror=alert(1)>", "{{ 7 * 6 }}", "a\u202eb\x1b"]
)
def test_hostile_names_stay_text(worse: Evaluation, name: str):
    beside = replace(worse.beside, baseline=replace(worse.beside.baseline, detector=name, made_on=name))
    text = render_page(replace(worse, detector=name, suite=name, beside=beside))
    page, plain = Page(), Page()
    page.feed(text)
    plain.feed(render_page(worse))
    assert page.open == []
    assert page.addresses == plain.addresses
    assert "<script" not in text
    assert not {"\u202e", "\x1b"} & set(text)
    assert "{{" not in name or "{{ 7 * 6 }}" in text


def test_page_lines_and_json_tell_what_e_c_and_s_do_at_rest(found: Evaluation):
    assert [list(each["features"]) for each in found.as_dict()["rest"]] == [
        ["entropy", "correlation", "similarity"] for _ in found.rest
    ]
    text, lines = render_page(found), "\n".join(describe(found))
    for place, measure, at_rest, touch, near in feature_rows(found.rest):
        assert f"<td>{measure}</td><td>{at_rest}</td><td>{touch}</td><td>{near}</td>" in text
        assert f"{measure} {at_rest} (touch {touch}, near {near} sd)" in lines
        assert place.split(",")[0] in lines


@pytest.mark.parametrize(
    ("made_by", "told"),
    [
        ({"sources": "0123456789abcdef"}, "made by another version of "),
        ({}, "made by unknown code"),
    ],
)
def test_code_of_a_baseline_is_told_where_the_frames_changed(
    evaluate: Callable[..., Evaluation], found: Evaluation, tmp_path: Path, made_by: dict[str, str], told: str
):
    file = tmp_path / "base.json"
    save_baseline(file, found.episodes, suite="tiny", detector="built-in")
    known = replace(load_baseline(file), made_by=made_by)
    same = evaluate(baseline=known)
    assert same.cannot_judge is None
    assert told not in "\n".join(describe(same))  # the frames are the same, so the code does not matter
    other = {
        name: replace(one, seen=FramesSeen(digest="0", levels=(0.0,) * 25)) for name, one in known.episodes.items()
    }
    worse = evaluate(tau_g=0.6, baseline=replace(known, episodes=other))
    assert (worse.is_worse, worse.regressions) == (False, [])
    assert (
        worse.cannot_judge == "0 shared takes with the baseline's frames in dark/rig, in which no fall could be found"
    )
    text = "\n".join(describe(worse))
    assert "the frames changed (simulator): 16 of 16 episodes" in text
    assert told in text
    assert "on the changed frames: Contact, balanced accuracy (dark/rig)" in text
    assert told in render_page(worse)
    assert len(worse.as_dict()["provenance"]["frames_changed"]) == 16
