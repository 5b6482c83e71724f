# SPDX-License-Identifier: MIT
"""An emulated instrument at work: on its port, with patches under it and somebody who presses."""

import argparse
import math
import os
import random
import sys
import time
from typing import Optional

from . import colorhug2, line, printalyzer, rci
from . import faults as wire
from .channel import Pty, SerialPort, Unplugged

MODELS = {"printalyzer": printalyzer, "line": line, "xrite-rci": rci, "colorhug2": colorhug2}
UNSEEN = 1.0  # seconds until somebody presses when nothing tells that the program listens


class Patches:
    """The densities that come under the instrument, one after the other."""

    def __init__(self, options: argparse.Namespace) -> None:
        dmax = options.dmax
        if dmax is None:
            dmax = options.dmin + math.log10(options.contrast)
        by_letter = {"w": options.dmin, "b": dmax}
        self.sequence = [by_letter[letter] for letter in options.order]
        self.sequence += [float(text) for text in options.steps.split(",") if text]
        self.options = options
        self.random = random.Random(options.seed)
        self.restart()

    def restart(self) -> None:
        self.taken = 0

    def next(self):
        """The next reading's density, or None when every patch was read."""
        patch = self.taken // max(1, self.options.auto_press)
        if patch >= len(self.sequence):
            return None
        density = self.sequence[patch] + self.options.drift * self.taken
        self.taken += 1
        return self.spoil(density)

    def spoil(self, density: float) -> float:
        return density + self.random.gauss(0.0, self.options.noise)


class Bench:
    """The instrument, its port and the person who presses. Densities that arrive on the file
    descriptor `hand`, one a line, are pressed at once; its end pulls the plug."""

    def __init__(self, options: argparse.Namespace, hand: Optional[int] = None) -> None:
        self.options = options
        self.hand = hand
        model, _, preset = options.model.partition(":")
        self.faults = wire.Faults(options.fault, MODELS[model].FAULTS)
        self.patches = Patches(options)
        if model == "printalyzer":
            self.instrument = printalyzer.Printalyzer(self.say, self.faults, options.mode)
        elif model == "line":
            self.instrument = line.LinePrinter(self.say, self.faults, preset)
        else:
            self.instrument = rci.Dtp41(self.say, self.faults, self.patches.next)
        self.channel = SerialPort(options.port, options.baud) if options.port else Pty()
        self.present = False
        self.quiet_since = math.inf
        self.presses_by_itself = options.auto_press > 0 and self.instrument.user_triggered

    def say(self, message: bytes, reading: bool) -> None:
        self.faults.send(self.channel, message, reading)

    def run(self) -> None:
        hands = [] if self.hand is None else [self.hand]
        while True:
            data, ready = self.channel.wait(self.options.interval, hands)
            if data is None:
                if self.present and self.options.once:
                    return
                self.present = False
                time.sleep(0.01)
            elif not self.present:
                self.present = True
                self.quiet_since = time.monotonic()
                self.patches.restart()
                self.instrument.connect()
            if data:
                self.quiet_since = time.monotonic()
                self.instrument.receive(data)
            if ready:
                self.obey()
            elif self.present and not data:
                self.press_when_due()

    def press_when_due(self) -> None:
        if not self.presses_by_itself or not self.instrument.ready:
            return
        quiet = time.monotonic() - self.quiet_since
        if quiet < (self.options.interval if self.channel.listened_to else UNSEEN):
            return
        density = self.patches.next()
        if density is not None:
            self.instrument.press(density)

    def obey(self) -> None:
        assert self.hand is not None
        text = os.read(self.hand, 4096).decode()
        if not text:
            raise Unplugged
        for word in text.split():
            try:
                density = float(word)
            except ValueError:
                print(f"lcor.emulator: {word[:20]!r} is no density", file=sys.stderr)
                continue
            self.instrument.press(self.patches.spoil(density))
