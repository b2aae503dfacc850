"""The same press gives the same bits in any process, on any number of cores."""

import os
import subprocess
import sys

import pytest

from magicsim.deform.solve.factorise import has_pardiso

SCRIPT = """
import hashlib
from magicsim.config.models import load_preset
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

changes = ["skin_mm=0.3137", "lattice.cells_across=0", "footprint_mm=[12, 14]"]
design = load_preset(ElastomerDesign, "design", "{design}", changes)
solver, state = ContactSolver(build_lattice(design), friction={friction}), None
punch = parse_object("punch:radius_mm=3,edge_radius_mm=0.5")
for pose in (dict(gap_mm=-0.4), dict(gap_mm=-0.4, x_mm=0.3)):
    state = solver.solve(place_object(punch, **pose), state)
    print(hashlib.sha256(state.displacements_mm.tobytes()).hexdigest())
"""


@pytest.mark.parametrize(
    ("design", "friction"), [pytest.param("uniform-block", 0.0, marks=pytest.mark.slow), ("mini-magictac", 0.5)]
)
def test_displacements_are_bit_identical_across_thread_settings(design: str, friction: float) -> None:
    script = SCRIPT.replace("{design}", design).replace("{friction}", str(friction))
    digests = []
    for threads, cores in ((1, 1), (2, 2)):
        variables = {name: str(threads) for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
        mask = set(sorted(os.sched_getaffinity(0))[:cores]) if hasattr(os, "sched_setaffinity") else None
        result = subprocess.run(
            [sys.executable, "-c", script],
            env=os.environ | variables,
            preexec_fn=(lambda mask=mask: os.sched_setaffinity(0, mask)) if mask else None,
            capture_output=True,
            text=True,
            check=True,
        )
        digests.append(result.stdout.strip())
    assert digests[0] == digests[1]
    assert isinstance(has_pardiso(), bool)
