"""What light meets: shapes, materials and lights of the scene that the renderer holds."""
