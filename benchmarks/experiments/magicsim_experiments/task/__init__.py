"""Tasks of a gripper in closed loop: frames in, motions out, judged by what really happened."""
