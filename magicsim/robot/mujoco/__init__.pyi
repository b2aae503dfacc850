from magicsim.robot.mujoco.coupling import Coupling
from magicsim.robot.mujoco.pair import Touch, compiled

__all__ = ["Coupling", "Touch", "compiled"]
