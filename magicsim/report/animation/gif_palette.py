"""One palette for all frames of an animated GIF, so that colours do not flicker from frame to frame."""

from collections.abc import Sequence

from PIL import Image, ImageColor

from magicsim.report.palette import CLASS_COLORS

PICTURE_COLORS = 120
"""Colours for the pictures; the colours of the classes come on top."""

_SAMPLED = 12
"""Number of frames that the colours are taken from."""


def shared_palette(pictures: Sequence[Image.Image]) -> Image.Image:
    """A palette image made from frames all over the stream.

    Args:
        pictures: RGB pictures of one size, at least one.
    """
    chosen = pictures[:: max(1, len(pictures) // _SAMPLED)]
    width, height = pictures[0].size
    montage = Image.new("RGB", (width * len(chosen), height))
    for place, each in enumerate(chosen):
        montage.paste(each, (place * width, 0))
    colors = montage.quantize(PICTURE_COLORS, Image.Quantize.MEDIANCUT).getpalette() or []
    fixed = [channel for color in CLASS_COLORS.values() for channel in ImageColor.getrgb(color)]
    palette = Image.new("P", (1, 1))
    palette.putpalette([*colors[: 3 * PICTURE_COLORS], *fixed])
    return palette
