"""Published experiments on the simulator: studies, learned models, tasks of the gripper."""
