# SPDX-License-Identifier: MIT
"""Everything that goes wrong between an instrument and a program, on request.

A fault is NAME or NAME=VALUE. Those of the wire work on every model:

    silence            never says anything
    slow=SECONDS       waits before every message
    chunk=BYTES        sends messages in pieces, 1 ms apart
    cut=BYTES          the first reading stops after so many bytes, and nothing follows
    garbage-before     noise, then the message
    garbage-inside     noise in the middle of the message
    garbage-after      the message, then noise
    flood              noise that never ends, instead of readings
    unplug-idle        the cable comes out before the first reading
    unplug-mid         the cable comes out in the middle of the first reading

Those of the instrument are the models' own: see their files.
"""

import time

from .channel import Unplugged

NOISE = bytes([0xFF, 0x00, 0x80, 0x1B, 0x11, 0x13, 0x03, 0x04, 0x1A]) + b"\n"
PIECE_PAUSE = 0.001


class Faults:
    """The faults asked for, and the wire they spoil."""

    def __init__(self, texts: list[str], known: set[str]) -> None:
        self.values: dict[str, str] = {}
        for text in texts:
            name, _, value = text.partition("=")
            if name not in known | WIRE:
                names = ", ".join(sorted(known | WIRE))
                raise ValueError(f"unknown fault '{name}'; known: {names}")
            self.values[name] = value

    def __contains__(self, name: str) -> bool:
        return name in self.values

    def number(self, name: str, default: float) -> float:
        return float(self.values.get(name) or default)

    def send(self, channel, message: bytes, reading: bool) -> None:
        """Send a message through the spoiled wire. `reading`: it carries a measured value."""
        if "silence" in self:
            return
        if reading and "unplug-idle" in self:
            raise Unplugged
        if "slow" in self:
            time.sleep(self.number("slow", 1.0))
        if reading and "unplug-mid" in self:
            channel.write(message[: len(message) // 2])
            time.sleep(PIECE_PAUSE)
            raise Unplugged
        if reading and "cut" in self:
            message = message[: int(self.number("cut", 1))]
            self.values["silence"] = ""
        if reading and "flood" in self:
            message = NOISE * 40
        if "garbage-before" in self:
            message = NOISE + message
        if "garbage-inside" in self:
            message = message[: len(message) // 2] + NOISE[:-1] + message[len(message) // 2 :]
        if "garbage-after" in self:
            message += NOISE
        size = int(self.number("chunk", len(message))) or 1
        for start in range(0, len(message), size):
            channel.write(message[start : start + size])
            if start + size < len(message):
                time.sleep(PIECE_PAUSE)


WIRE = {
    "silence",
    "slow",
    "chunk",
    "cut",
    "garbage-before",
    "garbage-inside",
    "garbage-after",
    "flood",
    "unplug-idle",
    "unplug-mid",
}
