from pathlib import Path

import pytest
from cli.conftest import Shell


def test_assembly_takes_json_set_and_seed(shell: Shell):
    done = shell("task", "assembly", "--help")
    assert done.code == 0
    assert all(option in done.out for option in ("--trials", "--out", "--json", "--set", "--seed"))


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["pressed"], "object.kind = 'sphere' is not allowed here: an assembly needs a 'plug'"),
        (["--trials", "0"], "trials = 0 is not allowed"),
        (["--set", "references=0"], "references = 0 is not allowed with task assembly: must be at least 3"),
        (["--quality", "best"], "unknown quality 'best'"),
        (["--set", "task.jack.radius=3"], "task assembly: unknown key in [jack] 'radius' (did you mean 'radius_mm'?)"),
        (["--set", "task.push_n=[0,4]"], "push_n"),
        (["--set", "task.success_mm=14"], "success_mm = 14 is not allowed: must be at most 12, the depth of the jack"),
        (["--set", "object.pin_radius_mm=5"], "pin_radius_mm = 5 is not allowed: must be below the handle's end, 4"),
    ],
)
def test_what_cannot_be_played_is_one_line(shell: Shell, tmp_path: Path, arguments: list[str], named: str):
    done = shell("task", "assembly", *arguments, "--out", str(tmp_path / "out"))
    assert done.code == 2
    assert named in done.err
    assert len(done.err.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()
