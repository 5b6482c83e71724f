# SPDX-License-Identifier: MIT
"""What can go wrong beyond ValueError, TypeError and MemoryError."""


class FormatError(ValueError):
    """A text (device profile) is not what it claims to be; the message names the line."""


class Cancelled(RuntimeError):
    """The progress callback asked a long call to stop."""


class NotConvergedWarning(UserWarning):
    """The solver stopped before the error asked for was reached; its report says how near."""
