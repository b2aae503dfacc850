"""What an equilibrium does to face, skin and infill: forces on taxels, stretch and stress, shear."""
