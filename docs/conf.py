# SPDX-License-Identifier: MIT
"""The documentation site: python -m sphinx -W docs build/docs (lcor installed, doxygen on PATH)."""

import subprocess
from pathlib import Path

import lcor

HERE = Path(__file__).parent
INCLUDE = HERE.parent / "lib" / "include"

project = "lcor"
version = release = lcor.__version__
copyright = "the lcor authors, MIT licence"
extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "myst_parser",
    "breathe",
]
html_theme = "furo"
html_title = f"lcor {version}"
html_static_path = []
exclude_patterns = ["requirements.txt"]
nitpicky = False

myst_enable_extensions = ["colon_fence", "dollarmath", "fieldlist"]
myst_heading_anchors = 3
source_suffix = {".md": "markdown"}

napoleon_google_docstring = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_default_options = {"members": True, "undoc-members": False}

breathe_default_project = "lcor"
breathe_domain_by_extension = {"h": "c"}


def run_doxygen(app):
    """The C headers as XML, beside the built site."""
    output = Path(app.doctreedir).parent / "doxygen"
    output.mkdir(parents=True, exist_ok=True)
    settings = (HERE / "Doxyfile").read_text()
    settings += f'INPUT = "{INCLUDE}"\nRECURSIVE = YES\nSTRIP_FROM_PATH = "{INCLUDE}"\n'
    settings += f'OUTPUT_DIRECTORY = "{output}"\n'
    subprocess.run(["doxygen", "-"], input=settings, text=True, check=True)
    app.config.breathe_projects = {"lcor": str(output / "xml")}


def setup(app):
    app.connect("builder-inited", run_doxygen, priority=100)
