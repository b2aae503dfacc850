"""The page: complete, self-contained, honest about mistakes and about what is missing."""

import base64
import io
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

from magicsim.geometry.objects.everyday import MeshObject
from magicsim.notebook.screen import EDGE_PX
from magicsim.report.page import render_report
from magicsim.report.tables import pick_frames
from magicsim.report.text import percent

from .synthetic import RIG, make_episode, make_judgement

VOID = {"meta", "img"}


class Reader(HTMLParser):
    """Tags with their attributes, and whether every tag is closed."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def episode():
    return make_episode()


@pytest.fixture(scope="module")
def judgements(episode):
    return [make_judgement(episode, "published", tau_e=0.5, tau_g=0.6), make_judgement(episode, tau_e=1.9)]


@pytest.fixture(scope="module")
def page(episode, judgements):
    return render_report(episode, judgements, {"Estimator": "fluence"})


def test_page_is_well_formed_and_ids_are_unique(page):
    reader = Reader(page)
    ids = [attrs["id"] for _, attrs in reader.tags if "id" in attrs]
    assert reader.open == []
    assert len(ids) == len(set(ids))


def test_page_needs_nothing_from_outside(page):
    tags = Reader(page).tags
    sources = [attrs["src"] for _, attrs in tags if "src" in attrs]
    assert sources
    assert all(source.startswith("data:image/") for source in sources)
    assert not {"script", "link", "iframe", "object"} & {tag for tag, _ in tags}
    links = [value for _, attrs in tags for name, value in attrs.items() if name.endswith("href")]
    assert all(link.startswith("#") for link in links)
    without_namespaces = re.sub(r'xmlns(:\w+)?="[^"]*"', "", page)
    assert not re.search(r"https?://|@import|url\((?!#)", without_namespaces)


def test_references_inside_the_page_have_targets(page):
    tags = Reader(page).tags
    ids = {attrs["id"] for _, attrs in tags if "id" in attrs}
    targets = set(re.findall(r'(?:url\(#|href="#)([^")]+)', page))
    assert targets
    assert targets <= ids


def test_page_states_profiles_accuracies_and_facts(page, judgements):
    for each in judgements:
        assert each.profile in page
        assert percent(each.score.proximity.accuracy) in page
        assert percent(each.score.contact.accuracy) in page
    assert "fluence" in page


def test_strange_names_are_escaped(episode):
    judgement = make_judgement(episode, "<script>alert('$x')</script>")
    page = render_report(episode, [judgement], {"<b>": "</dl>&"})
    assert "<script" not in page
    assert "&lt;script&gt;" in page
    assert "<dt>&lt;b&gt;</dt><dd>&lt;/dl&gt;&amp;</dd>" in page


def test_wrong_verdicts_are_marked(page, episode):
    assert 'figure class="wrong"' in page
    assert "✗" in page
    assert "Near called Normal" in page
    good = render_report(episode, [make_judgement(episode, tau_e=1.2, tau_g=0.89)], {})
    assert 'figure class="wrong"' not in good
    assert " called " not in good


def test_contact_sheet_shows_the_calibrated_profile_and_else_the_last(episode, judgements):
    assert "profile “calibrated”" in render_report(episode, judgements[::-1], {})
    assert "profile “published”" in render_report(episode, judgements[:1], {})


def test_same_input_gives_same_page(page, episode, judgements):
    assert page == render_report(episode, judgements, {"Estimator": "fluence"})


@pytest.mark.parametrize(
    ("keyframes", "proximity", "contact"),
    [
        ([{"frame": 0}, {"frame": 5}], "no frames of Near, Light", "no frames of Contact"),
        ([{"frame": 0}], "no frames of Near, Light", "no frames of Contact"),
        (
            [{"frame": 0, "gap_mm": 20.0}, {"frame": 6, "gap_mm": 1.0}],
            "no frames of Clear, Light",
            "no frames of Contact",
        ),
        (
            [{"frame": 0, "gap_mm": -0.5}, {"frame": 3, "gap_mm": -1.0}],
            "no frames of Clear, Near, Light",
            "no frames of Clear or Near or Light",
        ),
    ],
)
def test_page_says_which_frames_a_score_lacks(keyframes, proximity, contact):
    episode = make_episode(keyframes, references=0)
    page = render_report(episode, [make_judgement(episode)], {})
    assert f"not scored ({proximity})" in page
    assert f"not scored ({contact})" in page
    assert "No object in this episode" in page or keyframes[0].get("gap_mm") is not None
    assert ("No contact in this episode" in page) == (keyframes[-1].get("gap_mm", 1.0) > 0.0)


@pytest.mark.parametrize("references", [0, 3])
def test_frames_stand_beside_their_change_where_rest_is_known(references):
    episode = make_episode(references=references, rig=RIG | {"camera": {"gamma": 2.2}})
    page = render_report(episode, [], {})
    assert ("4 times its change against rest" in page) == bool(references)
    coded = re.search(r'src="data:image/webp;base64,([^"]+)"', page)
    shown = np.asarray(Image.open(io.BytesIO(base64.b64decode(coded[1]))).convert("RGB"), float)
    assert shown.shape == (32, 2 * 24 + EDGE_PX if references else 24, 3)
    first = episode.scored[pick_frames(episode.scored)[0]].image
    assert shown[:, :24].mean() == pytest.approx(first.mean(), abs=3)  # the camera has a tone curve


def test_page_without_judgements_has_no_verdicts(episode):
    page = render_report(episode, [], {})
    assert "No detector judged this episode" in page
    assert "says" not in re.sub(r"<style>.*?</style>|How to read this.*", "", page, flags=re.DOTALL)


HOSTILE = [
    "<script>alert(1)</script>", "</script><img src=x onerror=alert(1)>", '" onload="alert(1)', "{{ 7 * 6 }}{% raw %}",
    "a\u202egnp.exe", "\x1b[31m\x00", "]]><!--", "'&\"",
]  # fmt: skip


def test_hostile_names_of_profiles_facts_and_files_stay_text(episode):
    name = " ".join(HOSTILE)
    thing = MeshObject(kind="mesh", path=name)
    named = replace(episode, scene=episode.scene.model_copy(update={"object": thing}))
    page = render_report(named, [make_judgement(episode, name)], {"Note": name})
    plain = Reader(render_report(episode, [make_judgement(episode, "plain")], {"Note": "plain"}))
    tags = Reader(page).tags
    assert [tag for tag, _ in tags] == [tag for tag, _ in plain.tags]
    assert not any(key.startswith("on") for _, attributes in tags for key in attributes)
    assert "{{ 7 * 6 }}" in page
    assert not {"\u202e", "\x1b", "\x00"} & set(page)
