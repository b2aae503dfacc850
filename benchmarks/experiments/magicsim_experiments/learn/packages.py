"""Whether what learning needs is installed."""

import importlib.util

from magicsim.errors import ConfigError

PACKAGES = ("torch", "safetensors")


def need_torch(what: str) -> None:
    """Refuses to go on without PyTorch.

    Args:
        what: What needs it, as the user calls it.

    Raises:
        ConfigError: It, or the reader of its files, is not installed.
    """
    for name in PACKAGES:
        if importlib.util.find_spec(name) is None:
            msg = f"{what} needs the package {name}: pip install 'magicsim-experiments[learn]'"
            raise ConfigError(msg)
