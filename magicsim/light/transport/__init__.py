"""How light moves: particles from the lights fill the cells, camera paths gather what is there."""
