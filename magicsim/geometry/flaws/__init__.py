"""How a print differs from its drawing, as light sees it: uneven and missing walls, rough faces, bubbles, flakes."""
