"""Error and cost of light, and what the detectors need of it."""
