# SPDX-License-Identifier: MIT
"""Hughski ColorHug2, a colorimeter for displays on USB HID.

Faults of its own: error=N (take reading answers this code), error-once=N, short (reports of 20
bytes), stale (an answer to another command first), unplug (vanishes at the third reading).
"""

import struct

FAULTS = {"error", "error-once", "short", "stale", "unplug"}
REPORT = 64
WHITE = 160.0  # cd/m2 at density 0


def fixed(value: float) -> bytes:
    """Signed 16.16 fixed point, little-endian."""
    return struct.pack("<i", round(value * 65536.0))


class ColorHug2:
    """Answers one 64-byte request with one 64-byte report. Patches are given as densities below
    160 cd/m2."""

    def __init__(self, faults, next_density) -> None:
        self.faults = faults
        self.next_density = next_density
        self.readings = 0

    def exchange(self, request: bytes) -> list[bytes]:
        """The reports that answer a request; an empty list: silence."""
        if "silence" in self.faults:
            return []
        command = request[0]
        code, data = self.answer(command)
        report = bytes([code, command]) + data
        if "short" in self.faults:
            reports = [report.ljust(20, b"\xff")]
        else:
            reports = [report.ljust(REPORT, b"\xff")]
        if "stale" in self.faults:
            reports.insert(0, bytes([0, command ^ 0x40]).ljust(REPORT, b"\xff"))
        return reports

    def answer(self, command: int) -> tuple[int, bytes]:
        fixed_answers = {
            0x07: struct.pack("<3H", 2, 0, 7),
            0x0B: struct.pack("<I", 4711),
            0x30: b"\x02",
            0x3B: fixed(24.5),
        }
        if command in fixed_answers:
            return 0, fixed_answers[command]
        if command != 0x23:
            return 1, b""
        self.readings += 1
        for name in ("error", "error-once"):
            if name in self.faults and (name == "error" or self.readings == 1):
                return int(self.faults.values[name]), b""
        density = self.next_density()
        if density is None:
            return 4, b""
        luminance = WHITE * 10.0**-density
        return 0, fixed(luminance * 0.95) + fixed(luminance) + fixed(luminance * 1.08)
