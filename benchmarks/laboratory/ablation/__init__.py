"""The episodes of a suite with one part of the physics taken away."""
