"""What a compared design may be called: it is a folder of the study, a row and a column of its tables."""

import re
from typing import Annotated

from pydantic import AfterValidator

from magicsim.workers.run_folder import CONFIG, ERRORS
from magicsim_experiments.study.folder import DATA, INDEX, MODELS, PIECES, REPORT, RESULTS, TABLES

TAKEN = (CONFIG, DATA, ERRORS, INDEX, MODELS, PIECES, REPORT, RESULTS, TABLES)
"""Files and folders of every study; some disks do not tell `Data` from `data`."""
_FORM = re.compile(r"\w[\w .-]{0,59}")


def _checked(name: str) -> str:
    if not _FORM.fullmatch(name):
        msg = (
            f"'{name}' is not allowed as a name: must be letters, digits, '_', '-', '.' and spaces, at most 60, and "
            "begin with one of the first three"
        )
        raise ValueError(msg)
    if name.casefold() in {each.casefold() for each in TAKEN}:
        msg = f"'{name}' is not allowed as a name: a study has a file or folder that is called so"
        raise ValueError(msg)
    return name


DesignName = Annotated[str, AfterValidator(_checked)]
