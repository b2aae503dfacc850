"""Studies of what the block does: forces, stretch and stress, shear, displacement."""
