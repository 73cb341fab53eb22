"""How Sphinx builds the site: `make docs`."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))
# Kernels find the same checkout, need one thread, and have a profile of their own, which says only what goes wrong.
_PROFILE = tempfile.TemporaryDirectory()
Path(_PROFILE.name, "profile_default").mkdir()
Path(_PROFILE.name, "profile_default", "ipython_kernel_config.py").write_text("c.Application.log_level = 40\n")
os.environ |= {
    "IPYTHONDIR": _PROFILE.name,
    "PYTHONPATH": os.pathsep.join(filter(None, [str(HERE.parent), os.environ.get("PYTHONPATH")])),
    "OMP_NUM_THREADS": "1",
    "PYDEVD_DISABLE_FILE_VALIDATION": "1",
}

from ltlc.version import __version__  # noqa: E402

project, author, copyright = "ltlc", "The ltlc authors", "the ltlc authors"
release = version = __version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode", "site_pages"]
exclude_patterns = ["_build", "_ext"]
nitpicky = True

# Notebook pages are run whenever the site is built; an exception in a cell is an error of the build.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600  # seconds a cell; a busy machine is slow
nb_execution_in_temp = True
nb_merge_streams = True
nb_ipywidgets_js: dict[str, object] = {}
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4

# Docstrings are in Google's style, with `names` in single backticks.
default_role = "literal"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autodoc_default_options = {"members": True, "show-inheritance": True}
napoleon_use_ivar = True
napoleon_use_rtype = False
suppress_warnings = ["ref.python"]  # attributes of one name in several classes
# What is not ours, or is private, has no page to link to.
nitpick_ignore_regex = [("py:.*", r"(?!ltlc\b).*")]

smartquotes = False  # options begin with two hyphens

html_theme = "furo"
html_title = f"ltlc {__version__}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}
pygments_style, pygments_dark_style = "default", "monokai"
linkcheck_timeout = 20
