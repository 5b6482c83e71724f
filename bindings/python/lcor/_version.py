# SPDX-License-Identifier: MIT
"""The version of the compiled library."""

from ._core import version

__version__: str = version()
