"""The weights of a model file: put into the network that its header names, or refused in one line."""

import torch
from torch import nn

from magicsim.errors import ConfigError
from magicsim_experiments.learn.model_file import ModelConfig
from magicsim_experiments.learn.networks import build_network, output_places


def open_network(content: bytes, config: ModelConfig, *, source: str = "the model") -> nn.Module:
    """The network of a model file, with its weights.

    Args:
        content: The file's.
        config: Its header.
        source: What errors call it.

    Raises:
        ConfigError: The weights break off, are not those of the network, or are not finite.
    """
    network = build_network(config.network, output_places(config.labels)[-1].stop)
    load_weights(network, content, source=source)
    return network


def load_weights(network: nn.Module, content: bytes, *, source: str = "the model") -> None:
    """Puts the weights of a model file into a network.

    Args:
        network: Of the file's kind.
        content: The file's.
        source: What errors call it.

    Raises:
        ConfigError: As `open_network`.
    """
    from safetensors import SafetensorError
    from safetensors.torch import load

    try:
        weights = load(content)
    except (SafetensorError, ValueError, KeyError, TypeError, AttributeError, RuntimeError) as error:
        msg = f"model '{source}' holds no weights that can be read: {_first_line(error)}"
        raise ConfigError(msg) from None
    for name, wanted in network.state_dict().items():
        found = weights.get(name)
        if found is None or found.shape != wanted.shape or found.dtype != wanted.dtype:
            said = "missing" if found is None else f"{_kind(found)} and must be {_kind(wanted)}"
            msg = f"model '{source}' has weights of another network: '{name}' is {said}"
            raise ConfigError(msg)
        if not bool(torch.isfinite(found).all()):
            msg = f"model '{source}' has weights that are not finite: '{name}'"
            raise ConfigError(msg)
    if strange := sorted(set(weights) - set(network.state_dict())):
        msg = f"model '{source}' has weights of another network: '{strange[0]}' is not one of them"
        raise ConfigError(msg)
    network.load_state_dict(weights)


def _kind(tensor: torch.Tensor) -> str:
    return f"{str(tensor.dtype).removeprefix('torch.')} of shape {list(tensor.shape)}"


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0] or type(error).__name__
