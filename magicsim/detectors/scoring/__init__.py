"""True classes of frames, labelled episodes, and how verdicts are scored against them."""
