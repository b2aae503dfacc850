"""Noise, blur and cost of the light: questions to which `benchmarks/light.py` and `render.py` have the answers."""
