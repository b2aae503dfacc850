"""Mesh files that objects are read from, and files that a design is exported to."""
