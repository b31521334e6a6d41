"""Sphinx settings of the manual. `make docs` builds it; nothing on its pages needs a network."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tools"))

project = "ssmash_gym"
author = "The ssmash_gym authors"
language = "en"
extensions = ["myst_parser", "sphinx-mathjax-offline", "manual_pages"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4  # links to headings use the same names as on the repository's pages
exclude_patterns = ["**/.*"]  # files that are being written
html_theme = "furo"
html_title = "ssmash_gym"
html_static_path = ["_static"]
html_css_files = ["manual.css"]
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
