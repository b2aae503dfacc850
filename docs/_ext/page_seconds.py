"""How long each executed page took: the build says it, and warns of one that took longer than two minutes."""

import os

from myst_nb.sphinx_ import NbMetadataCollector
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util import logging

MOST_S = 120.0
"""Time that a page may take [s]."""
BUSY = 2.0
"""Load of a machine, in units of its cores, above which it does other work too, and times say nothing of a page."""
LOGGER = logging.getLogger(__name__)


def setup(app: Sphinx) -> dict[str, bool]:
    """Tells once all pages have been read."""
    app.connect("env-updated", tell)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def tell(app: Sphinx, env: BuildEnvironment) -> None:
    """Says what the pages took that were executed in this build or in the one that this one continues.

    The warning is an error under `-W`. On a machine that does much else at the time it is a plain line.
    """
    del app
    is_busy = os.getloadavg()[0] > BUSY * (os.cpu_count() or 1)
    for page, data in sorted(NbMetadataCollector.get_doc_data(env).items()):
        seconds = (data.get("exec_data") or {}).get("runtime")
        if seconds is None:
            continue
        if seconds > MOST_S and not is_busy:
            words = "took %.0f s: must be at most %.0f s"
            LOGGER.warning(words, seconds, MOST_S, location=page, type="page_seconds")
        else:
            LOGGER.info("%s took %.0f s%s", page, seconds, " beside other work" if is_busy else "")
