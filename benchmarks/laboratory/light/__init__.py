"""What the detectors need of light, and what it costs: questions to which `benchmarks/light.py` has the answers."""
