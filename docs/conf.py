"""Configuration of Sphinx for the manual: `python -m sphinx -W -b html docs OUT`."""

import logging
import os
import sys
from pathlib import Path

_FOLDER = Path(__file__).parent
sys.path[:0] = [str(_FOLDER / "_ext"), str(_FOLDER.parent)]
# Commands and notebooks of the manual find fivtui, and Python's own frozen modules need no file.
os.environ["PYTHONPATH"] = os.pathsep.join(
    filter(None, [str(_FOLDER.parent), os.environ.get("PYTHONPATH")])
)
os.environ["PYDEVD_DISABLE_FILE_VALIDATION"] = "1"
# A style of the theme would let all packages log what they do.
logging.basicConfig(level=logging.WARNING)

from fivtui import __version__  # noqa: E402

project = "fivtui"
author = "The fivtui authors"
copyright = author  # noqa: A001
release = version = __version__

extensions = [
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_click",
    "sphinx_copybutton",
    "myst_nb",
    "manual",
    "mathml",
]
root_doc = "index"
exclude_patterns = ["_ext"]
suppress_warnings = ["config.cache"]

html_math_renderer = "mathml"
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 60

add_module_names = False
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_use_type_comments = False
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
python_maximum_signature_line_length = 88

html_theme = "furo"
html_title = f"fivtui {release}"
html_static_path = ["_static"]
html_css_files = ["manual.css"]
html_copy_source = False
html_show_sourcelink = False
copybutton_selector = "div.highlight-sh pre, div.highlight-python pre, div.highlight-toml pre"
