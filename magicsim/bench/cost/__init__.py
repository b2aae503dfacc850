"""Cost of a warm step against the size of the lattice."""
