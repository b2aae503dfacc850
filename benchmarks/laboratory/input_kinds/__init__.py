"""Kinds of inputs and surroundings that once gave a silent wrong answer, three variations each, for `fault_inputs.py`."""
