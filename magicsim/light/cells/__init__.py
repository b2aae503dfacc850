"""The grid of cells as passes of light meet it: how a cell is put together, and its deformed faces."""
