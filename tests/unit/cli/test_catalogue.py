import shutil
import subprocess

import pytest

from magicsim.config.presets import preset_names

from .conftest import Shell


def test_list_names_presets_of_a_kind_a_line_each(shell: Shell):
    lines = shell("list", "rigs").out.splitlines()
    assert [line.split()[0] for line in lines] == preset_names("rig")
    assert shell.json("list", "rigs")["rigs"][0]["name"] == preset_names("rig")[0]
    every = shell("list").out
    assert all(name in every for name in ("designs:", "mini-magictac", "sweeps:", "cell-skin"))
    assert "did you mean 'objects'" in shell.refusal("list", "object")


@pytest.mark.parametrize("name", ["bash", "zsh", "fish"])
def test_completion_is_a_script_that_its_shell_reads(shell: Shell, name: str, tmp_path):
    done = shell("completion", name)
    assert done.code == 0
    assert "durometer" in done.out
    if shutil.which(name):
        (tmp_path / "script").write_text(done.out)
        subprocess.run([name, "-n", str(tmp_path / "script")], check=True)


def test_bash_completes_a_command(shell: Shell, tmp_path):
    (tmp_path / "script").write_text(shell("completion", "bash").out)
    ask = "source ./script; COMP_WORDS=(magicsim simu); COMP_CWORD=1; _magicsim; echo ${COMPREPLY[@]}"
    if shutil.which("bash"):
        done = subprocess.run(["bash", "-c", ask], capture_output=True, text=True, check=True, cwd=tmp_path)
        assert done.stdout.split() == ["simulate"]
