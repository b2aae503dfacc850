"""Inputs and surroundings that once gave a silent wrong answer, three variations of a kind, for `fault_inputs.py`."""
