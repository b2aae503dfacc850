"""What a user writes for the objects that approach and press.

`parse_object` is loaded when it is first used, so that importing the package stays light.
"""

from typing import TYPE_CHECKING

from magicsim.names import lazy_names

if TYPE_CHECKING:
    from magicsim.geometry.objects.kinds import parse_object

__all__ = ["parse_object"]

__getattr__, __dir__ = lazy_names("magicsim.geometry.objects", {"parse_object": "magicsim.geometry.objects.kinds"})
