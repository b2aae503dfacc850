"""How the documentation is built: `python -m sphinx -W docs build/docs`."""

import sys
from pathlib import Path

import magicsim

sys.path.append(str(Path(__file__).parent / "_ext"))

project = "magicsim"
author = "The magicsim authors"
release = version = magicsim.__version__
copyright = f"2026, {author}"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "command",
    "mathml",
    "page_seconds",
    "plain_docstrings",
]
exclude_patterns = ["_ext"]

nb_execution_mode = "auto"
nb_execution_timeout = 600  # of one cell, on a busy machine; `page_seconds` holds a page to two minutes
nb_execution_raise_on_error = True
nb_merge_streams = True
nb_output_stderr = "remove"  # a call says there how long it takes, which each build would print otherwise
nitpicky = False
default_role = "code"

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_class_signature = "separated"
napoleon_google_docstring = True
napoleon_numpy_docstring = False

html_theme = "furo"
html_title = "magicsim"
html_static_path = ["_static"]
html_css_files = ["wide.css"]
html_copy_source = False
html_show_sphinx = False
html_math_renderer = "mathml"
