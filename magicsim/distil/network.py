"""The network of a touch: a U-Net of some hundred thousand weights, which answers 0 before it has learned."""

from itertools import pairwise
from typing import TYPE_CHECKING, Any

from magicsim.emulator.model import TouchModel
from magicsim.errors import ConfigError

if TYPE_CHECKING:
    import torch

WIDTHS = (32, 64, 96, 128)
"""Channels at each resolution, from half of the image's on."""
CHANNELS = 3
OPSET, IR_VERSION = 17, 9
"""Versions of ONNX, as old as OpenCV's readers want them."""
MISSING = "distil needs PyTorch and ONNX: pip install 'magicsim[distil]'"


def find_torch() -> Any:  # noqa: ANN401 - a module that may be missing
    """PyTorch, which trains alone; it and ONNX must be installed (`ConfigError`), a finished model needs neither."""
    try:
        import onnx  # noqa: F401 - what ends the work is asked for before it begins
        import torch
    except ImportError:
        raise ConfigError(MISSING) from None
    return torch


def build_network(channels: int, widths: tuple[int, ...] = WIDTHS) -> "torch.nn.Module":
    """The network for so many channels of fields.

    Blocks add to what they are given, beginning with nothing, so that no layer of normalisation is needed, which would
    mix places whose light has nothing in common.
    """
    torch = find_torch()
    nn = torch.nn

    def quiet(layer: Any) -> Any:  # noqa: ANN401
        nn.init.zeros_(layer.weight)
        nn.init.zeros_(layer.bias)
        return layer

    class Block(nn.Module):  # type: ignore[misc, name-defined]
        def __init__(self, width: int) -> None:
            super().__init__()
            self.first = nn.Conv2d(width, width, 3, padding=1)
            self.second = quiet(nn.Conv2d(width, width, 3, padding=1))

        def forward(self, values: Any) -> Any:  # noqa: ANN401
            silu = nn.functional.silu
            return values + self.second(silu(self.first(silu(values))))

    class Network(nn.Module):  # type: ignore[misc, name-defined]
        def __init__(self) -> None:
            super().__init__()
            steps = list(pairwise(widths))
            self.enter = nn.Conv2d(channels, widths[0], 3, padding=1)
            self.down = nn.ModuleList(Block(width) for width in widths)
            self.shrink = nn.ModuleList(nn.Conv2d(wide, deep, 2, stride=2) for wide, deep in steps)
            self.enlarge = nn.ModuleList(nn.ConvTranspose2d(deep, wide, 2, stride=2) for wide, deep in steps)
            self.up = nn.ModuleList(Block(wide) for wide, _ in steps)
            self.leave = quiet(nn.Conv2d(widths[0], 4 * CHANNELS, 3, padding=1))

        def forward(self, fields: Any) -> Any:  # noqa: ANN401
            values, kept = self.enter(fields), []
            for block, shrink in zip(self.down, self.shrink, strict=False):
                kept.append(block(values))
                values = shrink(kept[-1])
            values = self.down[-1](values)
            for block, enlarge, beside in reversed(list(zip(self.up, self.enlarge, kept, strict=True))):
                values = block(enlarge(values) + beside)
            return nn.functional.pixel_shuffle(self.leave(nn.functional.silu(values)), 2)

    return Network()


def to_onnx(network: "torch.nn.Module") -> bytes:
    """The network for OpenCV's reader."""
    from onnx import TensorProto, helper, numpy_helper

    nodes: list[Any] = []
    weights = {name: value.numpy() for name, value in network.state_dict().items()}

    def call(kind: str, *inputs: str, **attributes: Any) -> str:  # noqa: ANN401
        nodes.append(helper.make_node(kind, inputs, [f"value{len(nodes)}"], **attributes))
        return f"value{len(nodes) - 1}"

    def layer(kind: str, name: str, values: str, **attributes: Any) -> str:  # noqa: ANN401
        return call(kind, values, f"{name}.weight", f"{name}.bias", **attributes)

    def silu(values: str) -> str:
        return call("Mul", values, call("Sigmoid", values))

    def block(name: str, values: str) -> str:
        inner = silu(layer("Conv", f"{name}.first", silu(values), pads=[1] * 4))
        return call("Add", values, layer("Conv", f"{name}.second", inner, pads=[1] * 4))

    values, kept = layer("Conv", "enter", "fields", pads=[1] * 4), []
    steps = range(sum(name.startswith("shrink") for name in weights) // 2)
    for step in steps:
        kept.append(block(f"down.{step}", values))
        values = layer("Conv", f"shrink.{step}", kept[-1], strides=[2, 2])
    values = block(f"down.{len(steps)}", values)
    for step in reversed(steps):
        values = call("Add", layer("ConvTranspose", f"enlarge.{step}", values, strides=[2, 2]), kept[step])
        values = block(f"up.{step}", values)
    values = layer("Conv", "leave", silu(values), pads=[1] * 4)
    nodes.append(helper.make_node("DepthToSpace", [values], ["change"], blocksize=2, mode="CRD"))
    shapes = {"fields": [1, weights["enter.weight"].shape[1], "rows", "columns"], "change": [1, CHANNELS, "r", "c"]}
    ends = {name: helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name, shape in shapes.items()}
    graph = helper.make_graph(
        nodes, "touch", [ends["fields"]], [ends["change"]],
        [numpy_helper.from_array(value, name) for name, value in weights.items()],
    )  # fmt: skip
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION)
    return bytes(model.SerializeToString(deterministic=True))


def start_from(network: "torch.nn.Module", model: TouchModel) -> None:
    """Gives a network the weights of a finished model; `ConfigError` where it was made of other layers or fields."""
    from onnx import load_from_string, numpy_helper

    torch = find_torch()
    try:
        kept = {each.name: numpy_helper.to_array(each) for each in load_from_string(model.network).graph.initializer}
        network.load_state_dict({name: torch.from_numpy(values.copy()) for name, values in kept.items()})
    except Exception as error:
        why = [type(error).__name__, *str(error).splitlines()[:2]][-1].strip()
        raise ConfigError(f"start = '{model.facts.name}' is not allowed: its network does not fit: {why}") from None
