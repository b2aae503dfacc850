import json
from pathlib import Path

import pytest

from magicsim.config import documents
from magicsim.config.documents import is_nested_deeper, parse_json, parse_toml, read_json, read_toml
from magicsim.config.models import apply_overrides
from magicsim.errors import ConfigError

DEEP = 5000


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "[" * DEEP + "]" * DEEP,
        "x = " + "{a=" * DEEP + "1" + "}" * DEEP,
        ".".join(["a"] * DEEP) + " = 1",
        "[" + ".".join(["a"] * DEEP) + "]\nx = 1",
        "x = { " + '"b" . ' * 100_000 + "c = 1 }",
        "x = " + "[" * 40 + "]" * 40,
        "x = " + "9" * 10_000,
    ],
)
def test_toml_that_is_nested_deeply_is_refused_in_one_line(text: str):
    with pytest.raises(ConfigError, match=r"nested too deeply|not valid TOML") as caught:
        parse_toml(text, source="my.toml")
    assert str(caught.value).startswith("my.toml")


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a":' * 100_000, "[" * 40 + "]" * 40, "{", "9" * 10_000])
def test_json_that_is_nested_deeply_or_broken_is_refused(text: str):
    with pytest.raises(ConfigError, match=r"^a\.json is"):
        parse_json(text, source="a.json")


def test_usual_files_are_read(tmp_path: Path):
    text = "values = [\n" + ", ".join(["0.5"] * 500) + "\n]\n[a.b.c]\nname = 'x.y.z'\n"
    assert parse_toml(text, source="")["a"] == {"b": {"c": {"name": "x.y.z"}}}
    (tmp_path / "a.json").write_text(json.dumps([{"a": 1}]))
    assert read_json(tmp_path / "a.json") == [{"a": 1}]
    (tmp_path / "marked.toml").write_text("a = 1\n", encoding="utf-8-sig")
    assert read_toml(tmp_path / "marked.toml") == {"a": 1}


def test_large_file_is_refused_before_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = tmp_path / "large.toml"
    path.write_bytes(b"#" * 200)
    monkeypatch.setattr(documents, "MAX_TOML_BYTES", 100)
    with pytest.raises(ConfigError, match="has 200 bytes: a TOML file may have at most 100"):
        read_toml(path)


def test_loops_of_links_and_long_names_cannot_be_read(tmp_path: Path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    for name in ("a", "x" * 300):
        with pytest.raises(ConfigError, match="cannot read"):
            read_toml(tmp_path / name)


@pytest.mark.parametrize(("value", "depth"), [(1, 0), ([1], 1), ({"a": [1, {"b": 2}]}, 3)])
def test_depth_counts_tables_and_lists(value: object, depth: int):
    assert not is_nested_deeper(value, depth)
    assert depth == 0 or is_nested_deeper(value, depth - 1)


@pytest.mark.parametrize(
    ("override", "named"),
    [
        (".".join(["a"] * DEEP) + "=1", "nested too deeply"),
        ("x=" + "[" * DEEP, "nested too deeply"),
        ("x=[1, 2", "not valid TOML"),
    ],
)
def test_override_that_cannot_be_read_is_refused(override: str, named: str):
    with pytest.raises(ConfigError, match=named):
        apply_overrides({}, [override])


def test_override_cannot_bring_another_key_with_it():
    assert apply_overrides({}, ["x=1\ny=2"]) == {"x": "1\ny=2"}
