"""The networks: ResNet18 (He, Zhang, Ren, Sun, CVPR 2016) and a small one, with one output a number or choice.

Written plainly: the wheels of torchvision on the package index are built against CUDA's PyTorch, and what is needed of
it is one class without its weights, which are of photographs.
"""

from collections import OrderedDict

import torch
from torch import nn

from magicsim.errors import ConfigError, unknown_choice
from magicsim_experiments.learn.model_file import ModelConfig, output_places
from magicsim_experiments.learn.settings import CHANNELS


def build_network(name: str, outputs: int, channels: int = 3) -> nn.Module:
    """A network from images (n, channels, rows, columns) to outputs (n, outputs)."""
    networks = {"small": _small, "resnet18": _resnet18}
    if name not in networks:
        raise ConfigError(unknown_choice("network", name, networks))
    return networks[name](outputs, channels)


def _small(outputs: int, channels: int) -> nn.Module:
    """Four convolutions that halve the image, and two layers on a grid of 4 by 4 that keep the place.

    About 0.2 million weights; a step takes a 25th of ResNet18's time at 60 x 80 pixels.
    """
    layers: list[nn.Module] = []
    for inside, outside in ((channels, 16), (16, 32), (32, 64), (64, 64)):
        layers += [nn.Conv2d(inside, outside, 3, stride=2, padding=1, bias=False), nn.BatchNorm2d(outside), nn.ReLU()]
    features = nn.Sequential(*layers, nn.AdaptiveAvgPool2d(4))
    head = nn.Sequential(nn.Flatten(), nn.Linear(1024, 128), nn.ReLU(), nn.Linear(128, outputs))
    return nn.Sequential(OrderedDict(features=features, head=head))


def _resnet18(outputs: int, channels: int) -> nn.Module:
    """Eight residual blocks of two convolutions, 64 to 512 channels."""
    stem = nn.Sequential(
        nn.Conv2d(channels, 64, 7, stride=2, padding=3, bias=False), nn.BatchNorm2d(64), nn.ReLU(),
        nn.MaxPool2d(3, stride=2, padding=1),
    )  # fmt: skip
    blocks = nn.Sequential(*(
        _Block(inside, outside, stride)
        for before, after in ((64, 64), (64, 128), (128, 256), (256, 512))
        for inside, outside, stride in ((before, after, 1 if before == after else 2), (after, after, 1))
    ))  # fmt: skip
    head = nn.Sequential(nn.AdaptiveAvgPool2d(1), nn.Flatten(), nn.Linear(512, outputs))
    return nn.Sequential(OrderedDict(stem=stem, blocks=blocks, head=head))


class _Block(nn.Module):
    """Two convolutions beside a shortcut."""

    def __init__(self, inside: int, outside: int, stride: int) -> None:
        super().__init__()
        self.body = nn.Sequential(
            nn.Conv2d(inside, outside, 3, stride=stride, padding=1, bias=False), nn.BatchNorm2d(outside), nn.ReLU(),
            nn.Conv2d(outside, outside, 3, padding=1, bias=False), nn.BatchNorm2d(outside),
        )  # fmt: skip
        self.shortcut: nn.Module = nn.Identity() if stride == 1 else nn.Sequential(
            nn.Conv2d(inside, outside, 1, stride=stride, bias=False), nn.BatchNorm2d(outside)
        )  # fmt: skip

    def forward(self, images: torch.Tensor) -> torch.Tensor:
        return torch.relu(self.body(images) + self.shortcut(images))


def network_of(config: ModelConfig) -> nn.Module:
    """The network of a model, with random weights."""
    return build_network(config.network, output_places(config.labels)[-1].stop, CHANNELS[config.input])


def open_network(content: bytes, config: ModelConfig, *, source: str = "the model") -> nn.Module:
    """The network of a model file, with its weights.

    Raises:
        ConfigError: The weights break off, are not those of the network, or are not finite.
    """
    network = network_of(config)
    load_weights(network, content, source=source)
    return network


def load_weights(network: nn.Module, content: bytes, *, source: str = "the model") -> None:
    """Puts the weights of a model file into a network."""
    from safetensors import SafetensorError
    from safetensors.torch import load

    try:
        weights = load(content)
        network.load_state_dict(weights)
    except (SafetensorError, ValueError, KeyError, TypeError, AttributeError, RuntimeError) as error:
        # PyTorch names what does not fit in the second line.
        why = [type(error).__name__, *str(error).splitlines()[:2]][-1].strip()
        raise ConfigError(f"model '{source}' holds no weights of its network that can be read: {why}") from None
    for name, wanted in network.state_dict().items():
        if weights[name].dtype != wanted.dtype or not bool(torch.isfinite(weights[name]).all()):
            raise ConfigError(f"model '{source}' has weights that are not {wanted.dtype} or are not finite: '{name}'")
