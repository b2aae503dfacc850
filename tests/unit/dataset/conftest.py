from pathlib import Path

import pytest

from magicsim.dataset.generate import generate_dataset
from magicsim.workers.options import WorkerOptions

from .fakes import FAKE, small_recipe


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished dataset of eleven episodes that cost nothing."""
    out = tmp_path_factory.mktemp("whole") / "set"
    generate_dataset(small_recipe("episodes=11"), out, options=WorkerOptions(workers=1), simulator=FAKE)
    return out
