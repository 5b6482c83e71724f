# SPDX-License-Identifier: MIT
"""X-Rite DTP41 on its remote control interface (RCI).

Faults of its own: error=HH (RM answers this status), error-once=HH (the first one only),
no-status (answers lack their status), two-decimals (refuses four).
"""

FAULTS = {"error", "error-once", "no-status", "two-decimals"}
END = {"00": "\r", "01": "\r\n", "02": "\n"}
SEPARATOR = {"00": " ", "01": ",", "02": "\t"}


class Dtp41:
    """Measures when told to: `next_density` is the patch under it."""

    user_triggered = False

    def __init__(self, say, faults, next_density) -> None:
        self.say = say
        self.faults = faults
        self.next_density = next_density
        self.connect()

    def connect(self) -> None:
        self.ready = False
        self.pending = b""
        self.switches = {"08": "01", "07": "01", "0A": "02", "06": "00"}
        self.luminance = 0.0
        self.error_sent = False

    def receive(self, data: bytes) -> None:
        for byte in data:
            if byte == 0x0D:
                line, self.pending = self.pending.decode("ascii", "replace").upper(), b""
                self.command(line)
            elif byte != 0x0A:
                self.pending += bytes([byte])

    def answer(self, status: str, text: str = "", reading: bool = False) -> None:
        end = END.get(self.switches["08"], "\r\n")
        message = text + end if text else ""
        if "no-status" not in self.faults:
            message += f"<{status}>{end}"
        self.say(message.encode(), reading)

    def command(self, line: str) -> None:
        if line in ("", "CE"):
            self.answer("00")
        elif line == "SV":
            self.answer("00", "X-Rite DTP41 1.2 0203")
        elif line.endswith("CF") and len(line) == 6:
            value, switch = line[:2], line[2:4]
            if switch == "0A" and value == "04" and "two-decimals" in self.faults:
                self.answer("13")
                return
            self.switches[switch] = value
            self.answer("00")
        elif line == "RM":
            self.measure()
        elif line == "0405TS":
            self.answer("00", self.xyz(), reading=True)
        else:
            self.answer("11")

    def measure(self) -> None:
        if "error" in self.faults:
            self.answer(self.faults.values["error"])
            return
        if "error-once" in self.faults and not self.error_sent:
            self.error_sent = True
            self.answer(self.faults.values["error-once"])
            return
        density = self.next_density()
        if density is None:
            self.answer("21")
            return
        self.luminance = 100.0 * 10.0**-density
        self.answer("00")

    def xyz(self) -> str:
        places = int(self.switches["0A"], 16)
        separator = SEPARATOR.get(self.switches["07"], "\t")
        scaled = (self.luminance * 0.9642, self.luminance, self.luminance * 0.8249)
        return separator.join(f"{value:.{places}f}" for value in scaled)
