"""From a scene to labelled frames: what is needed, one sensor in one scene, and the truth of every frame."""
