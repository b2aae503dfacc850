"""The report of an episode: an offline HTML page and an animated preview. Its modules load what they need."""
