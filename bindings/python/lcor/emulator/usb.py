# SPDX-License-Identifier: MIT
"""An emulated USB HID device: umockdev puts it under a program that uses hidapi unchanged.

    umockdev-wrapper python3 -m lcor.emulator --model colorhug2 --auto-press 5 -- lccal --port ...

Needs umockdev with its GObject introspection data and PyGObject (Debian: gir1.2-umockdev-1.0,
python3-gi; run it with the Python that python3-gi belongs to).
"""

import os
import subprocess
import tempfile
import threading
import time

NODE = "/dev/hidraw0"
DESCRIPTOR = bytes.fromhex("0600ff0901a10119012940150026ff00750895408102190129409102c0")

USB = "/devices/pci0000:00/0000:00:14.0/usb1/1-4"
HID = USB + "/1-4:1.0/0003:273F:1004.0001"
ATTRIBUTES = {
    "idVendor": "273f",
    "idProduct": "1004",
    "bcdDevice": "0200",
    "busnum": "1",
    "devnum": "5",
    "manufacturer": "Hughski Ltd.",
    "product": "ColorHug2",
}
DEVICE = f"""\
P: {HID}/hidraw/hidraw0
N: hidraw0
E: DEVNAME={NODE}
E: MAJOR=245
E: MINOR=0
E: SUBSYSTEM=hidraw
A: dev=245:0\\n
L: device=../../../0003:273F:1004.0001

P: {HID}
E: SUBSYSTEM=hid
E: DRIVER=hid-generic
E: HID_ID=0003:0000273F:00001004
E: HID_NAME=Hughski Ltd. ColorHug2
E: HID_PHYS=usb-0000:00:14.0-4/input0
E: HID_UNIQ=
H: report_descriptor={DESCRIPTOR.hex().upper()}

P: {USB}/1-4:1.0
E: SUBSYSTEM=usb
E: DEVTYPE=usb_interface
E: DRIVER=usbhid
A: bInterfaceNumber=00\\n

P: {USB}
N: bus/usb/001/005
E: SUBSYSTEM=usb
E: DEVTYPE=usb_device
E: DEVNAME=/dev/bus/usb/001/005
E: MAJOR=189
E: MINOR=4
""" + "".join(f"A: {name}={value}\\n\n" for name, value in ATTRIBUTES.items())

IOCTLS = (
    "@DEV /dev/hidraw0\n"
    "HIDIOCGRDESCSIZE 0 {size:02X}000000\n"
    "HIDIOCGRDESC 0 {size:02X}000000{data}\n"
).format(size=len(DESCRIPTOR), data=DESCRIPTOR.hex().upper().ljust(2 * 4096, "0"))


class Missing(Exception):
    """This machine cannot emulate USB devices."""


class MockedUsb:
    """The device node and the thread that answers on it."""

    def __init__(self, instrument, faults) -> None:
        try:
            import gi

            gi.require_version("UMockdev", "1.0")
            from gi.repository import UMockdev
        except (ImportError, ValueError) as error:
            raise Missing(f"umockdev for Python is missing: {error}") from error
        self.testbed = UMockdev.Testbed.new()
        if not UMockdev.in_mock_environment():
            raise Missing("run it under umockdev-wrapper")
        self.testbed.add_from_string(DEVICE)
        with tempfile.NamedTemporaryFile("w", suffix=".ioctl") as record:
            record.write(IOCTLS)
            record.flush()
            self.testbed.load_ioctl(NODE, record.name)
        self.fd = self.testbed.get_dev_fd(NODE)
        self.instrument = instrument
        self.faults = faults
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self) -> None:
        while True:
            try:
                request = os.read(self.fd, 65)
            except OSError:
                time.sleep(0.01)
                continue
            if len(request) != 65:
                continue
            for report in self.instrument.exchange(request[1:]):
                os.write(self.fd, report)
            if "unplug" in self.faults and self.instrument.readings == 3:
                os.close(self.fd)
                return

    def run(self, command: list[str]) -> int:
        return subprocess.run(command, check=False).returncode
