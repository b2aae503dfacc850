"""Error against run time of the deformation, beside independent solvers."""
