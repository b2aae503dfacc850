import pytest

from magicsim.config.presets import LONG, entries, first_sentence, plurals, preset_kinds, preset_names
from magicsim.errors import PresetError


@pytest.mark.parametrize("plural", plurals())
def test_every_preset_says_what_it_is(plural: str):
    found = entries(plural)
    assert [each.name for each in found] == preset_names(plurals()[plural])
    assert all(10 < len(each.description) <= LONG for each in found)


def test_every_kind_can_be_listed():
    assert list(plurals().values()) == preset_kinds()


def test_a_kind_that_does_not_exist_is_refused():
    with pytest.raises(PresetError, match=r"unknown kind of preset 'design'.*designs"):
        entries("design")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("# A ball of 3.5 mm. It rolls.\nkind = 'sphere'\n", "A ball of 3.5 mm"),
        ("# A ball that\n# rolls\n\n# no more\n", "A ball that rolls"),
        ("kind = 'sphere'\n", ""),
        ("# " + "word " * 40, ("word " * 21).strip() + " ..."),
    ],
)
def test_description_is_the_first_sentence(tmp_path, text: str, sentence: str):
    (tmp_path / "mine.toml").write_text(text)
    assert first_sentence(tmp_path / "mine.toml") == sentence
