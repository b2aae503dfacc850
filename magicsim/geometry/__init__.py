"""The printed elastomer: its design, grid, meshes and lattice planes, and the objects that touch it."""
