"""A dataset where nothing of this package is installed: a fresh environment with Hugging Face `datasets` alone."""

import hashlib
import json
import os
import subprocess
import sys
import venv
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from magicsim.dataset.manifest import read_manifest
from magicsim.dataset.shard import ARRAY_2D

pytestmark = pytest.mark.slow
READ = """
import hashlib, importlib.util, json, sys
import datasets, numpy as np
assert importlib.util.find_spec("magicsim") is None
loaded = datasets.load_dataset(sys.argv[1], cache_dir=sys.argv[2])
found = {}
for split, frames in loaded.items():
    row, arrays = frames[0], frames.with_format("numpy")[0]
    found[split] = {
        "rows": len(frames),
        "types": {name: type(feature).__name__ for name, feature in frames.features.items()},
        "dtypes": {name: getattr(feature, "dtype", None) for name, feature in frames.features.items()},
        "pixels": hashlib.sha256(np.asarray(row["image"]).tobytes()).hexdigest(),
        "image": list(np.asarray(row["image"]).shape),
        "mask": list(np.asarray(row["contact_mask"]).shape),
        "depth": [arrays["depth_map_mm"].dtype.name, *arrays["depth_map_mm"].shape],
        "moved": [arrays["displacements_mm"].dtype.name, arrays["displacements_mm"].shape[1]],
        "force_n": row["force_n"],
        "contact": row["contact"],
    }
sensors = datasets.load_dataset(sys.argv[1], "sensors", split="train", cache_dir=sys.argv[2])
found["sensors"] = {"rows": len(sensors), "design": json.loads(sensors[0]["design"])}
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of a fresh environment."""
    folder = tmp_path_factory.mktemp("clean") / "venv"
    venv.create(folder, with_pip=True)
    found = folder / "bin" / "python"
    install = [found, "-m", "pip", "install", "-q", "datasets", "pillow"]
    done = subprocess.run(install, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"datasets cannot be installed here: {done.stderr.strip().splitlines()[-1]}")
    return found


def test_dataset_is_read_with_its_documented_types_where_only_datasets_is_installed(
    python: Path, whole: Path, tmp_path: Path
):
    environment = {name: text for name, text in os.environ.items() if name != "PYTHONPATH"}
    environment["HF_HUB_OFFLINE"] = "1"
    command = [python, "-c", READ, str(whole), str(tmp_path / "cache")]
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found.pop("sensors")["rows"] == 4
    manifest = read_manifest(whole)
    assert {split: each["rows"] for split, each in found.items()} == {
        split: sum(entry.rows for entry in manifest.shards if entry.split == split)
        for split in {entry.split for entry in manifest.shards}
    }
    for split, each in found.items():
        schema = pq.read_schema(whole / "data" / f"{split}-00000.parquet")
        asked = json.loads(schema.metadata[b"huggingface"])["info"]["features"]
        assert set(each["types"]) == set(asked)
        for name, feature in asked.items():
            kinds = {"Sequence": ("List", "Sequence"), "Array2D": ("Array2D",)}.get(
                feature["_type"], (feature["_type"],)
            )
            assert each["types"][name] in kinds
            if feature["_type"] == "Value":
                assert each["dtypes"][name] == feature["dtype"]
        assert schema.field("depth_map_mm").metadata[b"ARROW:extension:name"].decode() == ARRAY_2D
        assert (each["image"], each["mask"]) == ([32, 24, 3], [32, 24])
        assert (each["depth"], each["moved"]) == (["float32", 32, 24], ["float32", 3])
        assert (len(each["force_n"]), each["contact"]) == (3, False)


def test_hashes_of_the_manifest_are_verified_without_this_package(whole: Path):
    script = (
        "import hashlib, json, pathlib, sys; folder = pathlib.Path(sys.argv[1]); "
        "manifest = json.loads((folder / 'manifest.json').read_text()); "
        "listed = manifest['files'] | {each['file']: each['sha256'] for each in manifest['shards']}; "
        "print(json.dumps([name for name, digest in listed.items() "
        "if hashlib.sha256((folder / name).read_bytes()).hexdigest() != digest]))"
    )
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-c", script, str(whole)], capture_output=True, text=True, check=True
    )
    assert json.loads(done.stdout) == []
    assert hashlib.sha256((whole / "README.md").read_bytes()).hexdigest() == read_manifest(whole).files["README.md"]
