"""Assumed optical constants: which there are, and what images of a real sensor say about them."""
