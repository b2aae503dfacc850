"""Entry of `python -m magicsim.detectors`."""

from magicsim.detectors.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
