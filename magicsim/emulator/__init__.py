"""Pictures of touches by a network that was distilled from true frames of one sensor (`render.tier = "fast"`)."""
