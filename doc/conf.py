"""How Sphinx builds these pages as HTML: ``make docs``. rosdoc2 reads the same file."""

from pathlib import Path
import sys

sys.path.insert(0, str(Path(__file__).parents[1]))

project = 'colortrack_ros'
author = 'colortrack_ros maintainers'
extensions = ['myst_parser', 'sphinx.ext.autodoc', 'sphinx.ext.viewcode']
source_suffix = {'.md': 'markdown', '.rst': 'restructuredtext'}
html_theme = 'sphinx_rtd_theme'
html_static_path = ['_static']
html_css_files = ['tables.css']

# Links such as parameters.md#tracker
myst_heading_anchors = 3

autodoc_member_order = 'bysource'
autodoc_typehints = 'description'
