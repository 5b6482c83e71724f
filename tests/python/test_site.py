# SPDX-License-Identifier: MIT
"""The documentation site builds without a warning."""

import importlib.util
import shutil
import sys

import pytest
from conftest import check

SITE = ["sphinx", "breathe", "myst_parser", "furo"]


@pytest.mark.skipif(
    any(importlib.util.find_spec(m) is None for m in SITE),
    reason="docs/requirements.txt is not installed",
)
@pytest.mark.skipif(shutil.which("doxygen") is None, reason="doxygen is not installed")
def test_the_site_builds_without_a_warning(source, tmp_path):
    for extra in ("dask.array", "matplotlib"):
        pytest.importorskip(extra)
    options = ["-q", "-W", "--keep-going", "-d", str(tmp_path / "doctrees")]
    check([sys.executable, "-m", "sphinx", *options, str(source / "docs"), str(tmp_path / "html")])
    for page, word in [("c", "lcor_correct_row"), ("python", "lcor.rgb_to_lab"), ("index", "lcor")]:
        assert word in (tmp_path / "html" / f"{page}.html").read_text()
