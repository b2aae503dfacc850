"""The stress grid: where the deformation is valid, refused, or silently wrong."""
