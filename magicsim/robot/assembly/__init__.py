"""A plug in the gripper and a base with a jack: what they do to each other, the stages, and who notices misalignment."""
