# SPDX-License-Identifier: MIT
"""Densitometers that print a line when the user presses, one format a preset of lccal's.

Faults of their own: damaged (a letter where a digit should be), standby (prints its stand-by line
first), relative (prints a relative reading first), colour-only (prints other filters than visual),
cr-only, split (one field a line), no-point (the decimal point is switched off).
"""

FAULTS = {"damaged", "standby", "relative", "colour-only", "cr-only", "split", "no-point"}


def fields(density: float, gap: str = "", comma: str = "") -> str:
    """V, C, M and Y, as X-Rite's programs print them."""
    others = zip("VCMY", (density, 0.05, 0.06, 0.07))
    return f"{comma} ".join(f"{letter}{gap}{value:.2f}" for letter, value in others)


def pointless(density: float) -> str:
    return f"{round(density * 100):03d}"


def signed(density: float) -> str:
    """T+1.53D: always seven characters."""
    return f"R{'-' if density < 0 else '+'}{abs(density):.2f}D"


FORMATS = {
    "heiland-trd2": lambda d: signed(d) + "\r",
    "xrite-400": lambda d: fields(d) + " \r\n",
    "xrite-photo": lambda d: f"V{d:.2f} R1.30 G1.35 B1.40 \r\n",
    "xrite-39x": lambda d: f"{d:.2f}\r\n",
    "xrite-500": lambda d: fields(d, " ", ",") + "\r\n",
    "technet": lambda d: f"V{pointless(d)}\r",
    "technet-adv": lambda d: f"P{pointless(d)} C005 M006 Y007 \r\n",
    "tobias-tbx": lambda d: f" DenAA {d:+.2f}, 0.00, 0.00, 0.00, 0.00\r\n",
    "macbeth-900": lambda d: f"V{d:.2f}\r\n",
    "generic": lambda d: f"Density: {d:.2f}\r\n",
}
STANDBY = {"heiland-trd2": "0+....D\r"}
RELATIVE = {"tobias-tbx": " DenAR +0.31, +1.44, +1.75, 0.00, 0.00\r\n", "heiland-trd2": "R+0.42Z\r"}


class LinePrinter:
    """Says nothing but readings; whatever the program sends is ignored."""

    user_triggered = True

    def __init__(self, say, faults, preset: str) -> None:
        if preset not in FORMATS:
            raise ValueError(f"no line preset '{preset}'; known: {', '.join(FORMATS)}")
        self.say = say
        self.faults = faults
        self.preset = preset
        self.connect()

    def connect(self) -> None:
        self.ready = True
        self.first = True

    def receive(self, data: bytes) -> None:
        """A line printer does not listen."""

    def line(self, density: float) -> str:
        line = FORMATS[self.preset](density)
        if "no-point" in self.faults:
            line = line.replace(".", "")
        if "damaged" in self.faults:
            line = line.replace(f"{density:.2f}"[-1], "x", 1)
        if "colour-only" in self.faults:
            line = "C0.05 M0.06 Y0.07 \r\n"
        if "split" in self.faults:
            line = line.replace(" ", "\r")
        if "cr-only" in self.faults:
            line = line.replace("\n", "")
        return line

    def press(self, density: float) -> None:
        if self.first and "standby" in self.faults:
            self.say(STANDBY.get(self.preset, "---\r\n").encode(), False)
        if self.first and "relative" in self.faults:
            self.say(RELATIVE.get(self.preset, "EEE\r\n").encode(), False)
        self.first = False
        self.say(self.line(density).encode(), True)
