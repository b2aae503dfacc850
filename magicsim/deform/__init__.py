"""Mechanics of the printed block: the lattice, its effective stiffness, rigid contact, and the solve.

Import from the modules themselves; this package imports nothing, so that it stays light.
"""
