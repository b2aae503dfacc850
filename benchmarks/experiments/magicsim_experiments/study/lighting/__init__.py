"""The study of light: which ways it takes through the walls of the grid, and what a touch does to its colours."""
