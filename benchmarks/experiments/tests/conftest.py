"""No test reads or writes the user's cache, or takes from it what it is to compute."""

import os

os.environ["MAGICSIM_CACHE"] = "off"
