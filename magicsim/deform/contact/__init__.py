"""Rigid contact on the face: where it is tested, the augmented Lagrangian, and Coulomb friction."""
