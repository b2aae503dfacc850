"""Headers and weights of model files: what a study writes, and what is refused."""

import json
from pathlib import Path

import pytest

from magicsim.errors import ConfigError
from magicsim_experiments.learn.model_file import HEADER, ModelConfig, parse_config, read_model
from magicsim_experiments.learn.samples import Label

GOOD = {
    "network": "small", "labels": [{"name": "x", "unit": "mm", "kind": "number", "choices": []},
                                   {"name": "size", "unit": "mm", "kind": "choice", "choices": [0.5, 1.0]}],
    "input": "difference", "long_side_px": 80, "frame_rows": 32, "frame_columns": 24,
    "input_mean": [0.1, 0.0, -0.1], "input_sd": [1.0, 2.0, 3.0], "target_mean": [0.5, 0.0], "target_sd": [2.0, 1.0],
    "recipe_hash": "", "study": "ranging",
}  # fmt: skip


def as_file(values: object, weights: bytes = b"") -> bytes:
    header = json.dumps({"__metadata__": {HEADER: json.dumps(values)}}).encode()
    return len(header).to_bytes(8, "little") + header + weights


def test_header_is_read_and_written_as_ever():
    found = parse_config(as_file(GOOD))
    assert found.labels[1] == Label(name="size", unit="mm", kind="choice", choices=(0.5, 1.0))
    assert found.input_sd == (1.0, 2.0, 3.0)
    assert json.dumps(found.model_dump(mode="json"), sort_keys=True) == json.dumps(GOOD, sort_keys=True)
    assert isinstance(found, ModelConfig)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"network": "nope"}, r"network = 'nope' is not allowed: must be 'small' or 'resnet18'"),
        ({"network": [1]}, r"network = \[1\] is not allowed"),
        ({"labels": []}, r"labels = \[\] is not allowed"),
        ({"labels": "abc"}, r"labels = 'abc' is not allowed"),
        ({"labels": GOOD["labels"][:1]}, r"target_mean = \[0.5, 0.0\] is not allowed: must have 1 numbers"),
        ({"labels": [GOOD["labels"][0]] * 2}, "names a label twice"),
        ({"labels": [GOOD["labels"][0] | {"name": "frame"}, GOOD["labels"][1]]}, "name = 'frame' is not allowed"),
        ({"labels": [GOOD["labels"][0] | {"name": "a\x1b[31m"}, GOOD["labels"][1]]}, "labels.0.name = "),
        ({"labels": [GOOD["labels"][0] | {"kind": "zz"}, GOOD["labels"][1]]}, "labels.0.kind = 'zz' is not allowed"),
        ({"labels": [GOOD["labels"][0], GOOD["labels"][1] | {"choices": []}]}, "must name at least one"),
        ({"labels": [GOOD["labels"][0], GOOD["labels"][1] | {"choices": [1, 0.5]}]}, "must ascend"),
        ({"labels": [GOOD["labels"][0], GOOD["labels"][1] | {"choices": ["a"]}]}, "labels.1.choices.0 = 'a'"),
        ({"input": "zz"}, "input = 'zz' is not allowed: must be 'difference', 'both' or 'frame'"),
        ({"long_side_px": -5}, "long_side_px = -5 is not allowed: must be a whole number of at least 0"),
        ({"long_side_px": 0.5}, "long_side_px = 0.5 is not allowed"),
        ({"long_side_px": 10**9}, "long_side_px = 1000000000 is not allowed"),
        ({"frame_rows": 0}, "frame_rows = 0 is not allowed"),
        ({"input_mean": [0, 0]}, r"input_mean = \[0.0, 0.0\] is not allowed: must have 3 numbers, one a channel"),
        ({"input": "both"}, r"input_mean = \[.*\] is not allowed: must have 6 numbers, one a channel"),
        ({"input_mean": None}, "input_mean = None is not allowed"),
        ({"input_sd": [0, 1, 1]}, "input_sd.0 = 0 is not allowed"),
        ({"input_sd": [float("nan")] * 3}, "input_sd.0 = nan is not allowed"),
        ({"target_sd": [float("inf"), 1.0]}, "target_sd.0 = inf is not allowed"),
        ({"target_sd": ["a", 1.0]}, "target_sd.0 = 'a' is not allowed"),
        ({"foo": 1}, "unknown key 'foo'"),
    ],
)  # fmt: skip
def test_header_that_says_what_is_not_allowed_is_refused_by_its_field(tmp_path: Path, changed: dict, said: str):
    path = tmp_path / "model.safetensors"
    path.write_bytes(as_file(GOOD | changed))
    with pytest.raises(ConfigError, match=said) as caught:
        read_model(path)
    assert str(caught.value).startswith(f"model '{path}': ")


@pytest.mark.parametrize("content", [b"", b"\x89PNG" * 100, bytes(1000), as_file([]), as_file(GOOD)[:100]])
def test_file_that_is_no_model_is_refused(tmp_path: Path, content: bytes):
    path = tmp_path / "model.safetensors"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match=rf"'{path}' is not a model of magicsim"):
        read_model(path)
    with pytest.raises(ConfigError, match="does not exist"):
        read_model(tmp_path / "none")
    with pytest.raises(ConfigError, match="is not a model of magicsim"):
        read_model(tmp_path)


def test_weights_that_do_not_fit_are_refused_by_name():
    torch = pytest.importorskip("torch")
    pytest.importorskip("safetensors")
    from magicsim_experiments.learn.model_file import save_model
    from magicsim_experiments.learn.networks import build_network, open_network

    config, network = parse_config(as_file(GOOD)), build_network("small", 3)
    weights = network.state_dict()
    good = save_model(config, weights)
    assert open_network(good, config, source="m").state_dict().keys() == weights.keys()

    def changed(name: str, tensor: object) -> bytes:
        return save_model(config, {key: each for key, each in (weights | {name: tensor}).items() if each is not None})

    bias = weights["head.3.bias"]
    for content, said in (
        (good[: len(good) // 2], "holds no weights of its network that can be read: .*deserializing"),
        (good[:-4], "holds no weights of its network that can be read: .*deserializing"),
        (changed("head.3.bias", None), 'read: Missing key.*"head.3.bias"'),
        (changed("head.3.bias", bias[:1].clone()), r"read: size mismatch for head.3.bias: .*\[1\].*\[3\]"),
        (changed("head.3.bias", bias.double()), "not torch.float32 or are not finite: 'head.3.bias'"),
        (changed("strange", bias.clone()), 'read: Unexpected key.*"strange"'),
        (changed("head.3.bias", bias * torch.nan), "are not finite: 'head.3.bias'"),
    ):
        with pytest.raises(ConfigError, match=rf"^model 'm' .*{said}"):
            open_network(content, config, source="m")
    with pytest.raises(ConfigError, match="unknown network 'nope'; available: resnet18, small"):
        build_network("nope", 3)


def test_model_that_comes_along_is_found_by_its_name(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.chdir(tmp_path)
    config, content = read_model(Path("localisation"))
    assert [f"{each.name} {each.unit}" for each in config.labels] == [
        "p_x mm",
        "p_y mm",
        "p_z mm",
        "f_x N",
        "f_y N",
        "f_z N",
    ]
    assert (config.frame_rows, config.frame_columns, config.input) == (320, 240, "both")
    assert len(content) < 10_000_000
    with pytest.raises(ConfigError, match=r"'localization' does not exist; models by name: localisation$"):
        read_model(Path("localization"))
    (tmp_path / "localisation").write_bytes(b"mine")
    with pytest.raises(ConfigError, match="'localisation' is not a model of magicsim"):
        read_model(Path("localisation"))
