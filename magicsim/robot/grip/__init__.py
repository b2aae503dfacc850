"""Two fingers that hold one object: the linkage that moves them, what acts on the object, where it rests or drops."""
