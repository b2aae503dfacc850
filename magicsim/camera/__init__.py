"""The camera behind the lens: how light, time and electronics make one frame differ from the next.

Everything here works on plain arrays and on the settings of a camera; nothing knows what is in front of the sensor, so
that no effect can tell a touch.
"""
