"""Colours of a report, told apart with any colour vision (Okabe and Ito, Color Universal Design, 2008)."""

from magicsim.frame_class import FrameClass

CLASS_COLORS = {
    FrameClass.CLEAR: "#999999",
    FrameClass.NEAR: "#56b4e9",
    FrameClass.CONTACT: "#cc79a7",
    FrameClass.LIGHT: "#f0e442",
}
"""Shade behind the frames of each class; frames that are not scored have none."""

ORANGE = "#e69f00"

INK = "#010203"
"""Stands for the page's colour of text until `THEME` replaces it."""
FAINT = "#010204"
"""Stands for the page's colour of thin lines until `THEME` replaces it."""
LINE = "#010205"
"""Stands for the page's colour of measured curves until `THEME` replaces it."""

BLUE = "#010206"
"""Stands for the page's blue until `THEME` replaces it."""
WRONG = "#010207"
"""Stands for the page's colour of wrong verdicts until `THEME` replaces it."""

THEME = {
    INK: "var(--ink, #1f2933)",
    FAINT: "var(--faint, #d5dae1)",
    LINE: "var(--curve, #0b3c6f)",
    BLUE: "var(--blue, #0072b2)",
    WRONG: "var(--mark, #d55e00)",
}
"""What replaces the stand-ins in a finished drawing, so that it follows the page's light or dark theme."""
