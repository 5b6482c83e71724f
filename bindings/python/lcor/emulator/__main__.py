# SPDX-License-Identifier: MIT
"""Run an emulated instrument: python -m lcor.emulator --help."""

import argparse
import contextlib
import sys
from typing import Optional

from . import colorhug2, usb
from . import faults as wire
from .bench import MODELS, Bench, Patches
from .channel import Unplugged


def arguments(argv: Optional[list[str]] = None) -> argparse.Namespace:
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
    return parser.parse_args(argv)


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
        if bench.instrument.user_triggered and not bench.presses_by_itself:
            bench.hand = sys.stdin.fileno()
    except ValueError as error:
        print(f"lcor.emulator: {error}", file=sys.stderr)
        return 2
    print(bench.channel.name, flush=True)
    with contextlib.suppress(Unplugged, KeyboardInterrupt):
        bench.run()
    bench.channel.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
