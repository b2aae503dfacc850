"""The commands that play a task of the gripper; each is in a module of its own."""

from cyclopts import App

from magicsim.cli.app import app

task_app = App(name="task", help="Play a task with two sensors on a gripper.")
app.command(task_app)
