# SPDX-License-Identifier: MIT
"""What an emulated instrument is plugged into: a pseudo-terminal or a real serial port."""

import errno
import fcntl
import os
import select
import struct
import termios
import tty
from typing import Optional


class Unplugged(Exception):
    """The emulated cable is out; nothing more can be said."""


FLUSH_READ = 1  # TIOCPKT_FLUSHREAD: the program has dropped what came before


class Pty:
    """The far end of a pseudo-terminal. `name` is what the program under test opens;
    `listened_to`: it has set the port up, so that what is said from now on is heard."""

    def __init__(self) -> None:
        self.master, slave = os.openpty()
        tty.setraw(slave)  # before anybody opens it, or the line discipline echoes
        self.name = os.ttyname(slave)
        os.close(slave)  # so that the program's closing shows as a hang-up
        # Packet mode: every read starts with a byte that tells what the program does to the port.
        fcntl.ioctl(self.master, termios.TIOCPKT, struct.pack("i", 1))
        self.listened_to = False

    def wait(self, seconds: float, others: list[int]) -> tuple[Optional[bytes], list[int]]:
        """Bytes that arrived (b"" for none, None while nobody has the port open), and which of
        the other descriptors are ready."""
        poller = select.poll()
        poller.register(self.master, select.POLLIN)
        for fd in others:
            poller.register(fd, select.POLLIN | select.POLLHUP)
        ready = dict(poller.poll(max(0.0, seconds) * 1000.0))
        events = ready.pop(self.master, 0)
        data: Optional[bytes] = b""
        if events & select.POLLIN:
            data = self.read()
        elif events & (select.POLLHUP | select.POLLERR):
            data = None
        if data is None:
            self.listened_to = False
        return data, list(ready)

    def read(self) -> Optional[bytes]:
        try:
            packet = os.read(self.master, 4096)
        except OSError as error:
            if error.errno != errno.EIO:
                raise
            return None
        self.listened_to = self.listened_to or bool(packet[0] & FLUSH_READ)
        return packet[1:]

    def write(self, data: bytes) -> None:
        os.write(self.master, data)

    def close(self) -> None:
        os.close(self.master)


class SerialPort:
    """A real port through pyserial, for instance one end of a null-modem cable."""

    listened_to = True  # nothing tells

    def __init__(self, name: str, baud: int) -> None:
        import serial

        self.name = name
        self.port = serial.Serial(name, baud, timeout=0)

    def wait(self, seconds: float, others: list[int]) -> tuple[Optional[bytes], list[int]]:
        ready, _, _ = select.select([self.port.fileno(), *others], [], [], max(0.0, seconds))
        fd = self.port.fileno()
        data = self.port.read(4096) if fd in ready else b""
        return data, [other for other in ready if other != fd]

    def write(self, data: bytes) -> None:
        self.port.write(data)

    def close(self) -> None:
        self.port.close()
