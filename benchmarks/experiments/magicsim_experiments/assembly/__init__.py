"""A plug in the gripper and a base with a jack: their contact, the stages, and who notices misalignment."""
