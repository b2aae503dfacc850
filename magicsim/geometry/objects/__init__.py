"""Objects that approach and press, as a user writes them."""

from magicsim.geometry.objects.kinds import parse_object

__all__ = ["parse_object"]
