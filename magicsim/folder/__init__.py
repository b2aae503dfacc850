"""Folders and files of results: whole or not there, one writer at a time, and nothing of anybody else's is lost.

magicsim removes or replaces a file only where it can show that it wrote it: a list in the folder has its size and hash.
Whatever is not whole yet has a name with a random part, which nobody else uses.
"""

from magicsim.folder.listing import LISTING
from magicsim.folder.result import PRODUCER, check_file, refuse_unsigned, result_file, result_folder
from magicsim.folder.target import MARKER, SIGNATURE, check_current_folder, check_place, check_target

__all__ = [
    "LISTING",
    "MARKER",
    "PRODUCER",
    "SIGNATURE",
    "check_current_folder",
    "check_file",
    "check_place",
    "check_target",
    "refuse_unsigned",
    "result_file",
    "result_folder",
]
