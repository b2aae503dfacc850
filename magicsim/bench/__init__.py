"""How accurate and how fast the deformation is, against independent solvers; and where it fails."""
