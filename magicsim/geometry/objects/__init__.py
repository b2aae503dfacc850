"""What a user writes for the objects that approach and press.

`parse_object` is loaded when it is first used, so that importing the package stays light.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from magicsim.geometry.objects.kinds import parse_object

__all__ = ["parse_object"]


def __getattr__(name: str) -> object:
    """Loads the public name from its module."""
    if name != "parse_object":
        msg = f"module 'magicsim.geometry.objects' has no attribute '{name}'"
        raise AttributeError(msg)
    from magicsim.geometry.objects.kinds import parse_object

    return parse_object
