import copy
from pathlib import Path
from typing import Annotated, Literal

import pytest
from pydantic import Field

from magicsim.config.documents import read_toml
from magicsim.config.models import Config, apply_overrides, load_preset, validate
from magicsim.errors import LINE_LENGTH, ConfigError, MagicsimError, PresetError, unknown_choice
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.scene import load_scene


class Ball(Config):
    kind: Literal["ball"]
    radius_mm: Annotated[float, Field(gt=0)]


class Brick(Config):
    kind: Literal["brick"]
    size_mm: float


class Layer(Config):
    depth_mm: float
    hidden: bool = False


class Step(Config):
    gap_mm: Annotated[float, Field(ge=-12, le=2000)] | None = None


class Way(Config):
    steps: Annotated[tuple[Step, ...], Field(min_length=1)]


class Table(Config):
    name: str = "table"
    count: int = 1
    thing: Annotated[Ball | Brick, Field(discriminator="kind")] | None = None
    layers: tuple[Layer, ...] = ()
    options: Layer | None = None


def refused(data: dict[str, object]) -> str:
    with pytest.raises(ConfigError) as caught:
        validate(Table, data, source="my.toml")
    message = str(caught.value)
    assert message.startswith("my.toml: ")
    assert "\n" not in message
    return message


def test_key_of_a_table_below_is_found_there():
    assert refused({"hidden": True}).endswith("; there is layers.hidden and options.hidden")


@pytest.mark.parametrize(
    ("overrides", "allowed"),
    [
        ("design.materials.body.poisson_ratio=0.5", "must be a number above -1 and below 0.5"),
        ("design.wall_mm=4", "must be a number of at least 0 and at most 3"),
        ("rig.camera.columns=ten", "must be a whole number of at least 8 and at most 2048"),
    ],
)
def test_number_that_is_not_allowed_comes_with_its_whole_range(overrides: str, allowed: str):
    with pytest.raises(ConfigError) as caught:
        load_scene("rest", [overrides])
    assert str(caught.value).endswith(f"is not allowed: {allowed}")


def test_misspelt_key_names_the_nearest_and_all_valid_keys():
    message = refused({"cuont": 3})
    assert "unknown key 'cuont' (did you mean 'count'?); available: count, layers, name, options, thing" in message


def test_unknown_key_without_a_near_one_lists_the_valid_keys():
    assert "unknown key 'zzz'; available: count, " in refused({"zzz": 3})


@pytest.mark.parametrize(
    ("data", "table", "valid"),
    [
        ({"layers": [{"depth_mm": 1.0}, {"depth_mm": 1.0, "hiden": True}]}, "layers.1", "depth_mm, hidden"),
        ({"options": {"depth_mm": 1.0, "hiden": True}}, "options", "depth_mm, hidden"),
        ({"thing": {"kind": "ball", "radius_mm": 1.0, "radius": 2}}, "thing", "kind, radius_mm"),
        ({"thing": {"kind": "brick", "size_mm": 1.0, "size": 2}}, "thing", "kind, size_mm"),
    ],
)
def test_unknown_key_inside_names_its_table_and_that_tables_keys(data: dict[str, object], table: str, valid: str):
    message = refused(data)
    assert f"unknown key in [{table}] " in message
    assert message.endswith(f"available: {valid}")


@pytest.mark.parametrize(
    ("data", "named"),
    [
        ({"count": 1.5}, "count = 1.5 is not allowed: must be a whole number"),
        ({"count": "many"}, "count = 'many'"),
        ({"count": True}, "count = True is not allowed: must not be true or false"),
        ({"name": 3}, "name = 3 is not allowed: must be a valid string"),
        ({"thing": {"kind": "ball", "radius_mm": -1}}, "thing.radius_mm = -1 is not allowed: must be a number above 0"),
        ({"thing": {"kind": "ball", "radius_mm": float("nan")}}, "thing.radius_mm = nan is not allowed"),
        ({"thing": {"kind": "ball", "radius_mm": float("inf")}}, "thing.radius_mm = inf is not allowed"),
        ({"thing": {"kind": "ball"}}, "thing.radius_mm is missing"),
        ({"thing": {"radius_mm": 1}}, "thing.kind is missing"),
        ({"thing": {"kind": "bal"}}, "unknown thing.kind 'bal' (did you mean 'ball'?); available: ball, brick"),
        ({"layers": [{"depth_mm": 1}, {"depth_mm": "deep"}]}, "layers.1.depth_mm = 'deep'"),
        ({"layers": [{"depth_mm": False}]}, "layers.0: depth_mm = False"),
        ({"layers": 3}, "layers = 3 is not allowed: must be a list"),
        ({"options": 3}, "options = 3 is not allowed: must be a table"),
    ],
)
def test_wrong_value_names_its_key_the_value_and_what_is_allowed(data: dict[str, object], named: str):
    assert named in refused(data)


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ([{"gap_mm": 3000}], "steps.0.gap_mm = 3000 is not allowed: must be a number of at least -12 and at most 2000"),
        ([{"gap_mm": 1}, {"gab": 2}], "unknown key in [steps.1] 'gab'; available: gap_mm"),
        ([], "steps = [] is not allowed: must hold at least 1"),
    ],
)
def test_a_list_with_wrong_entries_is_not_also_called_too_short(data: list[object], told: str):
    with pytest.raises(ConfigError) as caught:
        validate(Way, {"steps": data}, source="my.toml")
    assert str(caught.value) == f"my.toml: {told}"


def test_flag_may_be_true_or_false():
    assert validate(Table, {"options": {"depth_mm": 1, "hidden": True}}, source="my.toml").options is not None


def test_all_problems_are_told_and_an_unknown_key_comes_first():
    message = refused({"name": 3, "cuont": 2, "count": "many"})
    assert "unknown key 'cuont'" in message
    assert "; count = 'many' is not allowed" in message
    assert "; name = 3 is not allowed" in message
    assert message.index("cuont") < message.index("name = 3")


def test_more_problems_than_a_line_holds_are_told_by_their_keys():
    message = refused({"layers": [{"depth_mm": "deep"}] * 9, "cuont": 2})
    assert len(message) <= LINE_LENGTH
    assert "layers.0.depth_mm = 'deep' is not allowed" in message
    assert message.endswith("layers.7.depth_mm, layers.8.depth_mm")


def test_models_cannot_be_changed_once_checked():
    table = validate(Table, {}, source="my.toml")
    with pytest.raises(ValueError, match="frozen"):
        table.count = 2


def test_override_replaces_adds_and_makes_tables():
    data = {"count": 1, "options": {"depth_mm": 1.0}}
    changed = apply_overrides(data, ["count=2", "options.hidden=true", "new.inner.key=word", " name = 'a = b' "])
    assert changed == {
        "count": 2,
        "options": {"depth_mm": 1.0, "hidden": True},
        "new": {"inner": {"key": "word"}},
        "name": "a = b",
    }


@pytest.mark.parametrize(
    ("text", "value"),
    [("3", 3), ("3.0", 3.0), ("[1, 2]", [1, 2]), ("{a = 1}", {"a": 1}), ("word", "word"), ("a=b", "a=b"), ("", "")],
)
def test_override_value_is_toml_or_else_a_bare_word(text: str, value: object):
    changed = apply_overrides({}, [f"key={text}"])["key"]
    assert changed == value
    assert type(changed) is type(value)


def test_later_override_of_the_same_key_wins():
    assert apply_overrides({}, ["count=2", "count=3"]) == {"count": 3}


def test_overrides_leave_their_input_unchanged():
    data = {"options": {"inner": {"depth_mm": 1.0}}, "layers": [{"depth_mm": 1.0}]}
    before = copy.deepcopy(data)
    apply_overrides(data, ["options.inner.depth_mm=2", "options.more=1", "layers=[]"])
    assert data == before


@pytest.mark.parametrize("override", ["count", "=3", ".count=3", "options..depth=3", "options.=3", ""])
def test_override_of_a_bad_form_is_refused(override: str):
    with pytest.raises(ConfigError, match=r"is not of the form dotted\.key=value"):
        apply_overrides({}, [override])


def test_override_through_a_value_is_refused():
    with pytest.raises(ConfigError, match="'count' is a value, not a table"):
        apply_overrides({"count": 1}, ["count.inner=3"])


@pytest.mark.parametrize("content", [b"count = ", b"[table\n", b"count = 1\ncount = 2\n", b"name = '\xff'"])
def test_file_that_is_not_toml_is_refused_by_name(tmp_path: Path, content: bytes):
    path = tmp_path / "broken.toml"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match=r"broken\.toml is not valid TOML"):
        read_toml(path)


def test_file_that_cannot_be_read_is_refused(tmp_path: Path):
    with pytest.raises(ConfigError, match="cannot read"):
        read_toml(tmp_path)


def test_preset_is_loaded_by_name_with_overrides():
    design = load_preset(ElastomerDesign, "design", "mini-magictac", ["skin_mm=0.6", "materials.body.ior=1.5"])
    assert design.skin_mm == 0.6
    assert design.materials.body.ior == 1.5
    assert load_preset(ElastomerDesign, "design", "mini-magictac").skin_mm == 0.8


@pytest.mark.parametrize(
    ("override", "named"),
    [
        ("render.sample=3", "unknown key in [render] 'sample' (did you mean 'samples'?)"),
        ("keyframes=[{frame=0, gap=1.0}]", "unknown key in [keyframes.0] 'gap' (did you mean 'gap_mm'?)"),
        (
            "rig.strips=[{side='-x', radience=[1,1,1]}]",
            "unknown key in [rig.strips.0] 'radience' (did you mean 'radiance'",
        ),
        ("object.radius=3", "unknown key in [object] 'radius' (did you mean 'radius_mm'?)"),
        (
            "object={kind='box', length=3}",
            "available: color, edge_radius_mm, kind, pitch_deg, roll_deg, roughness, size_mm, specular, yaw_deg",
        ),
        ("object.kind='sphre'", "unknown object.kind 'sphre' (did you mean 'sphere'?)"),
        ("design.materials.infill.sigma=1", "unknown key in [design.materials.infill] 'sigma'"),
        ("design.skin_mm=nan", "design.skin_mm = nan is not allowed: must be a finite number"),
        ("rig.camera.field_mm=-1", "field_mm = -1 is not allowed: must be a number of at least 0.1 and at most 1000"),
        ("rig.strips=[{side='up', radiance=[1,1,1]}]", "rig.strips.0.side = 'up' is not allowed: must be '-x', '+x', "),
        ("keyframes=[]", "keyframes = [] is not allowed"),
        ("seed=-1", "seed = -1 is not allowed"),
        ("references=true", "references = True is not allowed"),
    ],
)
def test_wrong_setting_anywhere_in_a_scene_is_one_line_that_names_it(override: str, named: str):
    with pytest.raises(ConfigError) as caught:
        load_scene("near", [override])
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


def test_all_deliberate_errors_are_value_errors_of_one_base():
    assert issubclass(MagicsimError, ValueError)
    assert all(issubclass(error, MagicsimError) for error in (ConfigError, PresetError))


def test_unknown_choice_says_so_when_there_is_none():
    assert unknown_choice("design", "mini", []) == "unknown design 'mini'; available: none"
