# SPDX-License-Identifier: MIT
"""CUPS and PWG raster without libcups, from PWG 5102.4 and the CUPS raster format."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

import numpy as np

HEADER = 1796
# Offsets of the header's words.
ORDER = {
    "NumCopies": 340,
    "cupsWidth": 372,
    "cupsHeight": 376,
    "cupsBitsPerColor": 384,
    "cupsBitsPerPixel": 388,
    "cupsBytesPerLine": 392,
    "cupsColorOrder": 396,
    "cupsColorSpace": 400,
    "cupsNumColors": 420,
    "PrintQuality": 484,
    "ImageBoxLeft": 464,
}
STRINGS = 580  # cupsString[16]
W, RGB, K, CMYK, SGRAY, SRGB, ADOBERGB = 0, 1, 3, 6, 18, 19, 20
CHUNKED, BANDED, PLANAR = 0, 1, 2
MARK = b"lcor corrected"


@dataclass
class Page:
    """Samples (height, width, colours), and header words that differ from the honest ones."""

    pixels: np.ndarray
    space: int = SRGB
    order: int = CHUNKED
    words: dict[str, int] = field(default_factory=dict)
    strings: dict[int, bytes] = field(default_factory=dict)

    def rows(self, big: bool) -> list[bytes]:
        data = self.pixels.astype(self.pixels.dtype.newbyteorder(">" if big else "<"))
        if self.order == BANDED:
            data = np.moveaxis(data, 2, 1)
        return [row.tobytes() for row in np.ascontiguousarray(data)]

    def header(self, big: bool, media_class: bytes) -> bytes:
        height, width, colours = self.pixels.shape
        bits = 8 * self.pixels.dtype.itemsize
        words = {
            "NumCopies": 1,
            "cupsWidth": width,
            "cupsHeight": height,
            "cupsBitsPerColor": bits,
            "cupsBitsPerPixel": bits if self.order == BANDED else bits * colours,
            "cupsBytesPerLine": width * colours * bits // 8,
            "cupsColorOrder": self.order,
            "cupsColorSpace": self.space,
            "cupsNumColors": colours,
        } | self.words
        header = bytearray(HEADER)
        header[: len(media_class)] = media_class
        for name, value in words.items():
            struct.pack_into(">I" if big else "<I", header, ORDER[name], value)
        for index, text in self.strings.items():
            header[STRINGS + 64 * index : STRINGS + 64 * index + len(text)] = text
        return bytes(header)


def pack(row: bytes, size: int) -> bytes:
    """PackBits of one row of `size`-byte pixels, in the literal runs and repeats of PWG 5102.4."""
    pixels = [row[i : i + size] for i in range(0, len(row), size)]
    out, i = bytearray(), 0
    while i < len(pixels):
        run = 1
        while i + run < len(pixels) and run < 128 and pixels[i + run] == pixels[i]:
            run += 1
        if run > 1:
            out += bytes([run - 1]) + pixels[i]
        else:
            while (
                i + run < len(pixels)
                and run < 128
                and (i + run + 1 == len(pixels) or pixels[i + run] != pixels[i + run + 1])
            ):
                run += 1
            out += (bytes([257 - run]) if run > 1 else b"\0") + b"".join(pixels[i : i + run])
        i += run
    return bytes(out)


def write(pages: list[Page], kind: str = "v3") -> bytes:
    """kind: v3 (raw, little-endian), v3-big, v2 (compressed), pwg."""
    big = kind in ("v3-big", "pwg")
    out = [{"v3": b"3SaR", "v3-big": b"RaS3", "v2": b"2SaR", "pwg": b"RaS2"}[kind]]
    for page in pages:
        out.append(page.header(big, b"PwgRaster" if kind == "pwg" else b""))
        for row in page.rows(big):
            if kind in ("v2", "pwg"):
                step = page.pixels.dtype.itemsize * (
                    1 if page.order == BANDED else page.pixels.shape[2]
                )
                out.append(b"\0" + pack(row, step))
            else:
                out.append(row)
    return b"".join(out)


def unpack(
    data: bytes, at: int, height: int, row_bytes: int, size: int, space: int
) -> tuple[list[bytes], int]:
    rows: list[bytes] = []
    while len(rows) < height:
        repeat, at = data[at] + 1, at + 1
        row = bytearray()
        while len(row) < row_bytes:
            code, at = data[at], at + 1
            if code == 128:
                row += (b"\0" if space in (K, CMYK) else b"\xff") * (row_bytes - len(row))
            elif code < 128:
                row += data[at : at + size] * (code + 1)
                at += size
            else:
                row += data[at : at + (257 - code) * size]
                at += (257 - code) * size
        rows += [bytes(row)] * repeat
    return rows, at


def read(data: bytes) -> list[Page]:
    sync = data[:4]
    big = sync in (b"RaS2", b"RaS3")
    compressed = sync in (b"RaS2", b"2SaR")
    assert sync in (b"RaS2", b"RaS3", b"3SaR", b"2SaR"), sync
    pages, at = [], 4
    while at < len(data):
        header, at = data[at : at + HEADER], at + HEADER
        words = {
            k: struct.unpack_from(">I" if big else "<I", header, o)[0] for k, o in ORDER.items()
        }
        colours, height, width = words["cupsNumColors"], words["cupsHeight"], words["cupsWidth"]
        bits, row_bytes = words["cupsBitsPerColor"], words["cupsBytesPerLine"]
        step = bits // 8 * (1 if words["cupsColorOrder"] == BANDED else colours)
        if compressed:
            rows, at = unpack(data, at, height, row_bytes, step, words["cupsColorSpace"])
            body = b"".join(rows)
        else:
            body, at = data[at : at + height * row_bytes], at + height * row_bytes
        kind = np.dtype("u1" if bits == 8 else (">u2" if big else "<u2"))
        pixels = np.frombuffer(body, kind).astype(kind.newbyteorder("="))
        if words["cupsColorOrder"] == BANDED:
            pixels = np.moveaxis(pixels.reshape(height, colours, width), 1, 2)
        strings = {
            i: header[STRINGS + 64 * i : STRINGS + 64 * (i + 1)].rstrip(b"\0") for i in range(16)
        }
        pages.append(
            Page(
                pixels.reshape(height, width, colours),
                words["cupsColorSpace"],
                words["cupsColorOrder"],
                words,
                {i: s for i, s in strings.items() if s},
            )
        )
    return pages
