"""Which values of the assumed constants bring the simulated sensor to the published figures."""
