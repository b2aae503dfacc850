"""From a design to a file for the printer, and how much material it takes.

python docs/examples/print_volume.py       # writes block.3mf here
"""

from pathlib import Path

from magicsim.config.models import load_preset
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.files.export import Export, export_design


def export(out: Path, settings: list[str]) -> Export:
    """Writes mini-MagicTac with some settings changed."""
    return export_design(load_preset(ElastomerDesign, "design", "mini-magictac", settings), out)


if __name__ == "__main__":
    done = export(Path("block.3mf"), [])
    print(f"clear {done.volume_mm3:.1f} mm3, infill {done.infill_volume_mm3:.1f} mm3")
