import pytest

from .conftest import Shell


@pytest.mark.parametrize("kind", ["design", "scene", "rig", "object", "profile", "suite"])
def test_schema_is_one_json_object_for_every_kind(shell: Shell, kind: str):
    found = shell.json("schema", kind)
    assert "properties" in found or "oneOf" in found


def test_doctor_prints_the_contract(shell: Shell):
    found = shell.json("doctor")
    assert {"variant", "llvm", "cores", "problems"} <= set(found)
    assert found["variant"] in {"llvm_ad_rgb", "scalar_rgb"}
    assert isinstance(found["problems"], list)
