# SPDX-License-Identifier: MIT
"""Run an emulated instrument: python -m lcor.emulator --help."""

import argparse
import contextlib
import math
import os
import random
import sys
import time

from . import colorhug2, line, printalyzer, rci, usb
from . import faults as wire
from .channel import Pty, SerialPort, Unplugged

MODELS = {"printalyzer": printalyzer, "line": line, "xrite-rci": rci, "colorhug2": colorhug2}
SETTLE = 0.1  # seconds of silence after the last command before somebody presses


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m lcor.emulator",
        description="An emulated densitometer or colorimeter. The first line it prints is the "
        "port it is on. Densities read from standard input, one a line, are pressed at once.",
        epilog="\n".join(
            part.__doc__.partition("\n\n")[2] if part is wire else f"{name}: {part.__doc__}"
            for name, part in (("", wire), *MODELS.items())
        ),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--model", default="printalyzer",
                        help="printalyzer, line:PRESET, xrite-rci or colorhug2 [printalyzer]")
    parser.add_argument("--port", help="a serial port to be on, through pyserial [a new pty]")
    parser.add_argument("--baud", type=int, default=115200, help="of that port")
    parser.add_argument("--dmin", type=float, default=0.07, help="density of white [0.07]")
    parser.add_argument("--dmax", type=float, help="density of black [dmin + log10 of contrast]")
    parser.add_argument("--contrast", type=float, default=23.4, help="Jmax/Jmin [23.4]")
    parser.add_argument("--steps", default="", help="densities of further patches: 0.3,0.6,0.9")
    parser.add_argument("--order", default="wb", help="patches read: wb, bw, wbwb, ww ... [wb]")
    parser.add_argument("--auto-press", type=int, default=0, metavar="N",
                        help="read every patch N times by itself once a program is there")
    parser.add_argument("--interval", type=float, default=0.02, help="seconds between [0.02]")
    parser.add_argument("--noise", type=float, default=0.0, help="standard deviation in D [0]")
    parser.add_argument("--drift", type=float, default=0.0, help="D added with each reading [0]")
    parser.add_argument("--seed", type=int, default=1, help="of the noise [1]")
    parser.add_argument("--mode", default="R", choices=("R", "T"), help="reflection, transmission")
    parser.add_argument("--fault", action="append", default=[], metavar="NAME[=VALUE]")
    parser.add_argument("--once", action="store_true", help="end when the program closes the port")
    parser.add_argument("command", nargs="*", help="colorhug2: the program to run on it")
    return parser.parse_args()


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
    """The instrument, its port and the person who presses."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options
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
        by_hand = self.instrument.user_triggered and not options.auto_press
        self.inputs = [sys.stdin.fileno()] if by_hand else []

    def say(self, message: bytes, reading: bool) -> None:
        self.faults.send(self.channel, message, reading)

    def run(self) -> None:
        print(self.channel.name, flush=True)
        while True:
            data, ready = self.channel.wait(self.options.interval, self.inputs)
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
        if not (self.options.auto_press and self.instrument.user_triggered):
            return
        if not self.instrument.ready:
            return
        if time.monotonic() - self.quiet_since < SETTLE:
            return
        density = self.patches.next()
        if density is not None:
            self.instrument.press(density)

    def obey(self) -> None:
        """Densities from standard input are pressed; its end ends the program."""
        text = os.read(sys.stdin.fileno(), 4096).decode()
        if not text:
            raise Unplugged
        for word in text.split():
            self.instrument.press(self.patches.spoil(float(word)))


def run_on_usb(options: argparse.Namespace) -> int:
    """A USB device lives as long as the program that runs on it."""
    patches = Patches(options)
    faults = wire.Faults(options.fault, colorhug2.FAULTS)
    try:
        device = usb.MockedUsb(colorhug2.ColorHug2(faults, patches.next), faults)
    except usb.Missing as error:
        print(f"lcor.emulator: {error}", file=sys.stderr)
        return 77
    return device.run(options.command)


def main() -> int:
    options = arguments()
    try:
        if options.model.partition(":")[0] not in MODELS:
            raise ValueError(f"no model '{options.model}'; known: {', '.join(MODELS)}")
        if options.model == "colorhug2":
            return run_on_usb(options)
        bench = Bench(options)
    except ValueError as error:
        print(f"lcor.emulator: {error}", file=sys.stderr)
        return 2
    with contextlib.suppress(Unplugged, KeyboardInterrupt):
        bench.run()
    bench.channel.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
