"""Design sweeps: many sensors judged by the same measures, and a page to explore them."""
