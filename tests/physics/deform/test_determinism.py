"""The same press gives the same bits in any process, on any number of cores."""

import os
import subprocess
import sys

from magicsim.deform.linear import has_pardiso

SCRIPT = """
import hashlib
import numpy as np
from magicsim.deform.lattice import box_lattice
from magicsim.deform.path import ContactSolver
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects import SphereObject

across = np.linspace(-6, 6, 13)
solver = ContactSolver(box_lattice((across, across, np.linspace(0, 6, 7)), shear_modulus_mpa=0.4, lame_mpa=15.0))
state = solver.solve(place_object(SphereObject(kind="sphere", radius_mm=4.0), gap_mm=-0.5))
print(hashlib.sha256(state.displacements_mm.tobytes()).hexdigest())
"""


def test_displacements_are_bit_identical_across_thread_settings() -> None:
    digests = []
    for threads, cores in ((1, 1), (2, 2)):
        variables = {name: str(threads) for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
        mask = set(sorted(os.sched_getaffinity(0))[:cores]) if hasattr(os, "sched_setaffinity") else None
        result = subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env=os.environ | variables,
            preexec_fn=(lambda mask=mask: os.sched_setaffinity(0, mask)) if mask else None,
            capture_output=True,
            text=True,
            check=True,
        )
        digests.append(result.stdout.strip())
    assert digests[0] == digests[1]
    assert isinstance(has_pardiso(), bool)
