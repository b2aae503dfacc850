from pathlib import Path

import pytest

from .conftest import Shell


@pytest.mark.parametrize("name", ["block.stl", "block.3mf", "block.glb"])
def test_export_prints_the_contract_and_writes_the_file(shell: Shell, tmp_path: Path, name: str):
    found = shell.json("export", "uniform-block", "--out", name)
    assert {"watertight", "volume_mm3"} <= set(found)
    assert found["watertight"] is True
    assert found["volume_mm3"] == pytest.approx(24 * 32 * 6)
    assert (tmp_path / name).stat().st_size > 1000
