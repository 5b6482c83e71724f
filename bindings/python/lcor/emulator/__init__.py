# SPDX-License-Identifier: MIT
"""Emulated densitometers and colorimeters, for trying lccal without a device and for its tests.

    python -m lcor.emulator --model printalyzer --auto-press 5

prints the name of a pseudo-terminal on which the instrument listens; give it to `lccal --port`.
Nothing here needs the compiled part of lcor.
"""
