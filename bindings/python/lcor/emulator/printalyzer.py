# SPDX-License-Identifier: MIT
"""Dektronics Printalyzer Densitometer DPD-100: commands, both reading formats, faults.

Faults of its own: wrong-echo (answers name another command), nak, err (to everything but GS V,
nak=all and err=all to that too), chatter (a log line and a reading between command and reply),
stale (a reading before the first command), uncalibrated (no target calibration, so pressing does
nothing), basic (refuses the extended format), cr-only (lines end in CR).
"""

import math
import struct

FAULTS = {"wrong-echo", "nak", "err", "chatter", "stale", "uncalibrated", "basic", "cr-only"}
RANGE = {"R": 2.5, "T": 5.0}


def hex_float(value: float) -> str:
    """IEEE-754 single, most significant digit first."""
    return "7FC00000" if math.isnan(value) else struct.pack(">f", value).hex().upper()


class Printalyzer:
    """One DPD-100. `say(message, reading)` puts bytes on the wire."""

    user_triggered = True

    def __init__(self, say, faults, mode: str = "R") -> None:
        self.say = say
        self.faults = faults
        self.mode = mode
        self.last = {"R": math.nan, "T": math.nan}
        self.connect()

    def connect(self) -> None:
        """A program opens the port: raising DTR resets the reporting format."""
        self.format = "BASIC"
        self.pending = b""
        self.ready = False  # the program has set us up
        self.greeted = False

    def receive(self, data: bytes) -> None:
        for byte in data:
            if byte in b"\r\n":
                line, self.pending = self.pending, b""
                if line:
                    self.command(line.decode("ascii", "replace"))
            elif 0x20 <= byte <= 0x7E and len(self.pending) < 64:
                self.pending += bytes([byte])

    def end(self) -> str:
        return "\r" if "cr-only" in self.faults else "\r\n"

    def command(self, line: str) -> None:
        if len(line) < 3 or line[0] not in "SGI" or line[1] not in "SMCD" or line[2] != " ":
            return
        action, _, arguments = line[3:].partition(",")
        head = f"{line[:2]} {action[:7]}"
        if "stale" in self.faults and not self.greeted:
            self.press(0.9)
        self.greeted = True
        if "chatter" in self.faults:
            self.say(b"I/sensor: gain 64x\r\n", False)
            self.say(self.reading_line(0.9), False)
        if "wrong-echo" in self.faults:
            head = f"{line[:2]} X{action[1:7]}"
        self.say(f"{head},{self.reply(head, arguments)}{self.end()}".encode(), False)

    def reply(self, head: str, arguments: str) -> str:
        for name in ("nak", "err"):
            if name in self.faults and (head != "GS V" or self.faults.values[name] == "all"):
                self.ready = True
                return name.upper()
        if head == "SM FORMAT":
            self.ready = True
            if arguments not in ("BASIC", "EXT") or "basic" in self.faults:
                return "NAK"
            self.format = arguments
            return "OK"
        answers = {
            "GS V": '"Printalyzer Densitometer","v1.1.0"',
            "GS UID": "0123456789ABCDEF01234567",
            "GS B": '"2023-06-13 10:25","v1.1.0-0-gf91c91e","D3C4A5B6"',
            "GS ISEN": "3300mV,24.5C",
            "GC REFL": self.calibration(0.08, 0.3201, 1.50, 0.0123),
            "GC TRAN": self.calibration(0.0, 0.9871, 3.0, 0.00098),
            "GM REFL": hex_float(self.last["R"]),
            "GM TRAN": hex_float(self.last["T"]),
        }
        return answers.get(head, "NAK")

    def calibration(self, *values: float) -> str:
        if "uncalibrated" in self.faults:
            values = (math.nan,) * 4
        return ",".join(hex_float(value) for value in values)

    def reading_line(self, density: float) -> bytes:
        density = min(max(density, 0.0), RANGE[self.mode])
        line = f"{self.mode}{density:+.2f}D"
        if self.format == "EXT":
            count = 0.3201 * 10.0 ** (0.08 - density)
            fields = (density, math.nan, count, count * 0.9)
            line += "".join("," + hex_float(value) for value in fields)
        return (line + self.end()).encode()

    def press(self, density: float) -> None:
        """The user presses the button on a patch of this density."""
        if "uncalibrated" in self.faults:
            return
        self.last[self.mode] = min(max(density, 0.0), RANGE[self.mode])
        self.say(self.reading_line(density), True)
