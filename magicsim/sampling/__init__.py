"""Numbers drawn for recipes and sweeps: points of the unit cube, and the distributions that they are turned into."""
