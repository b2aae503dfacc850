"""Light and image of one frame: the untouched sensor's, and what the frame changes of it."""
