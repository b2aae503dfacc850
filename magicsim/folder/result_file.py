"""Files of results that appear whole under their final name, or not at all."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from magicsim.errors import OutputError
from magicsim.folder.naming import beside, check_writable
from magicsim.folder.result import output_errors

PRODUCER = "magicsim"
"""What a picture or a mesh says made it."""
SIGNED_BYTES = 4096
"""Where that stands in the file, at the latest."""


def refuse_unsigned(target: Path) -> None:
    """Refuses to replace a file that the user did not name, but for one that begins as magicsim's do.

    Args:
        target: File beside the one that was named.

    Raises:
        OutputError: There is another file, or it cannot be read.
    """
    with output_errors(target):
        if not target.is_file():
            return
        with target.open("rb") as file:
            if PRODUCER.encode() in file.read(SIGNED_BYTES):
                return
        msg = f"'{target}' would be replaced, and magicsim did not write it; move it away, or name another output"
        raise OutputError(msg)


def check_file(target: Path) -> None:
    """Refuses a file that cannot be written, before any work is done for it.

    Raises:
        OutputError: It is a folder, something above it is a file, its name is too long, or nothing can be made there.
    """
    with output_errors(target):
        if target.is_dir():
            msg = f"output file '{target}' is a folder; name a file"
            raise OutputError(msg)
        check_writable(target, beside(target, "partial"))


@contextmanager
def result_file(target: Path) -> Iterator[Path]:
    """A file to write beside the target, which takes its place when the block ends without an error.

    Raises:
        OutputError: The target is a folder or cannot be written, see `check_file`.
    """
    check_file(target)
    with output_errors(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        partial = beside(target, "partial")
        try:
            yield partial
            partial.replace(target)
        finally:
            with suppress(OSError):
                partial.unlink(missing_ok=True)
