import json
from pathlib import Path

import pytest

from magicsim.errors import OutputError
from magicsim.folder.ledger import JOURNAL, WORK, Ledger
from magicsim.folder.listing import Listed


def names(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_file_appears_whole_and_the_journal_goes_at_the_end(tmp_path: Path):
    ledger = Ledger(tmp_path, {})
    with ledger.writing("data/a.parquet") as partial:
        partial.write_bytes(b"rows")
        assert not (tmp_path / "data" / "a.parquet").exists()
    ledger.place("index.json", b"{}")
    assert names(tmp_path) == [f"{WORK}/{JOURNAL}", "data/a.parquet", "index.json"]
    assert ledger.listed("data/a.parquet").size == 4
    ledger.close()
    assert names(tmp_path) == ["data/a.parquet", "index.json"]


def test_failed_file_leaves_the_earlier_one(tmp_path: Path):
    ledger = Ledger(tmp_path, {})
    ledger.place("a.txt", b"old")
    with pytest.raises(ZeroDivisionError), ledger.writing("a.txt") as partial:
        partial.write_bytes(b"%d" % (1 // 0))
    assert (tmp_path / "a.txt").read_bytes() == b"old"
    assert names(tmp_path) == [f"{WORK}/{JOURNAL}", "a.txt"]


def test_next_run_knows_what_a_killed_one_wrote_and_removes_what_it_had_begun(tmp_path: Path):
    ledger = Ledger(tmp_path, {})
    ledger.place("a.txt", b"whole")
    writing = ledger.writing("b.txt")
    partial = writing.__enter__()
    partial.write_bytes(b"half")
    again = Ledger(tmp_path, {})  # the journal alone tells
    assert not partial.exists()
    again.refuse_foreign()
    again.place("a.txt", b"new")
    assert (tmp_path / "a.txt").read_bytes() == b"new"


def test_line_of_the_journal_that_was_cut_off_costs_no_other(tmp_path: Path):
    Ledger(tmp_path, {}).place("a.txt", b"whole")
    with (tmp_path / WORK / JOURNAL).open("a") as journal:
        journal.write('{"file": "b.txt", "tok')
    Ledger(tmp_path, {}).place("c.txt", b"whole")
    Ledger(tmp_path, {}).refuse_foreign()


@pytest.mark.parametrize("name", [".mine.tmp", ".a.txt.tmp", f"{WORK}/notes.txt", "data/.b.0123456789abcdef.tmp"])
def test_foreign_file_is_kept_and_named(tmp_path: Path, name: str):
    Ledger(tmp_path, {}).place("a.txt", b"whole")
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("mine")
    ledger = Ledger(tmp_path, {})
    with pytest.raises(OutputError, match=f"holds '{name}', not as magicsim wrote it"):
        ledger.refuse_foreign()
    ledger.close()
    assert (tmp_path / name).read_text() == "mine"


def test_somebody_elses_file_is_neither_replaced_nor_removed(tmp_path: Path):
    ledger = Ledger(tmp_path, {})
    (tmp_path / "a.txt").write_text("mine")
    for act in (lambda: ledger.place("a.txt", b"new"), lambda: ledger.remove("a.txt")):
        with pytest.raises(OutputError, match=r"holds 'a\.txt'"):
            act()
    assert (tmp_path / "a.txt").read_text() == "mine"
    ledger.remove("not there")


def test_edited_text_is_foreign_and_damaged_rows_are_made_again(tmp_path: Path):
    ledger = Ledger(tmp_path, {})
    for name in ("a.toml", "a.parquet"):
        ledger.place(name, b"seed = 1")
        (tmp_path / name).write_bytes(b"seed = 2")
    assert not ledger.is_own("a.toml")
    assert ledger.is_own("a.parquet")
    assert not ledger.is_intact("a.parquet")
    (tmp_path / "a.parquet").write_bytes(b"something else")
    assert not ledger.is_own("a.parquet")


def test_what_an_index_lists_is_known_after_the_index_has_been_replaced(tmp_path: Path):
    first = Ledger(tmp_path, {})
    first.place("a.txt", b"whole")
    known = {"a.txt": Listed(sha256=first.listed("a.txt").sha256)}
    first.close()
    Ledger(tmp_path, known).place("index.json", b"{}")
    Ledger(tmp_path, {}).refuse_foreign()


def test_journal_that_leads_elsewhere_or_was_changed_is_not_followed(tmp_path: Path):
    out, victim = tmp_path / "out", tmp_path / ".victim.0123456789abcdef.tmp"
    Ledger(out, {}).place("a.txt", b"whole") if out.mkdir() is None else None
    victim.write_text("mine")
    with (out / WORK / JOURNAL).open("a") as journal:
        journal.write(json.dumps({"file": "../victim", "token": "0123456789abcdef", "facts": None}) + "\n")
    Ledger(out, {}).refuse_foreign()
    assert victim.read_text() == "mine"
