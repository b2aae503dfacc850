"""Simulated takes of all types of sensors, from which the units of `rest-relative` are fitted and judged."""
