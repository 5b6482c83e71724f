# SPDX-License-Identifier: MIT
"""Small glTF files for the tests, built number by number."""

from __future__ import annotations

import base64
import json
import struct
import zlib

QUAD = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
QUAD_UV = [(0, 1), (1, 1), (1, 0), (0, 0)]
FORMATS = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}


def png(width: int, height: int, pixels: bytes, colour_type: int = 2, depth: int = 8) -> bytes:
    """Rows of raw samples as a PNG file."""
    step = len(pixels) // height
    raw = b"".join(b"\0" + pixels[y * step : (y + 1) * step] for y in range(height))

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    header = struct.pack(">IIBBBBB", width, height, depth, colour_type, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(raw))
        + chunk(b"IEND", b"")
    )


class Scene:
    """Collects accessors and nodes; `document` may be edited freely before writing."""

    def __init__(self) -> None:
        self.buffer = b""
        self.document: dict = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}

    def add(self, kind: str, item: dict) -> int:
        self.document.setdefault(kind, []).append(item)
        return len(self.document[kind]) - 1

    def view(self, data: bytes) -> int:
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        view = self.add(
            "bufferViews", {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data)}
        )
        self.buffer += data
        return view

    def accessor(self, rows: list, component: int = 5126, **more: object) -> int:
        flat = [x for row in rows for x in (row if isinstance(row, (tuple, list)) else (row,))]
        size = len(flat) // len(rows)
        data = struct.pack(f"<{len(flat)}{FORMATS[component]}", *flat)
        return self.add(
            "accessors",
            {
                "bufferView": self.view(data),
                "componentType": component,
                "count": len(rows),
                "type": ["", "SCALAR", "VEC2", "VEC3", "VEC4"][size],
                **more,
            },
        )

    def mesh(
        self, points: list, indices: list | None = None, uv: list | None = None, **more: object
    ) -> int:
        attributes = {"POSITION": self.accessor(points)}
        if uv:
            attributes["TEXCOORD_0"] = self.accessor(uv)
        attributes.update(more.pop("attributes", {}))  # type: ignore[call-overload]
        primitive: dict = {"attributes": attributes, **more}
        if indices:
            primitive["indices"] = self.accessor(indices, 5123)
        return self.add("meshes", {"primitives": [primitive]})

    def quad(self, points: list | None = None, **more: object) -> int:
        return self.mesh(points or QUAD, [0, 1, 2, 0, 2, 3], QUAD_UV, **more)

    def material(self, rgb: tuple = (0.5, 0.5, 0.5), **more: object) -> int:
        return self.add(
            "materials",
            {"pbrMetallicRoughness": {"baseColorFactor": [*rgb, 1], "metallicFactor": 0}, **more},
        )

    def textured(self, image: bytes, wrap: int = 10497, **info: object) -> int:
        """A material with this picture."""
        source = self.add("images", {"bufferView": self.view(image), "mimeType": "image/png"})
        sampler = self.add("samplers", {"wrapS": wrap, "wrapT": wrap})
        texture = self.add("textures", {"source": source, "sampler": sampler})
        return self.add(
            "materials",
            {
                "pbrMetallicRoughness": {
                    "baseColorTexture": {"index": texture, **info},
                    "metallicFactor": 0,
                }
            },
        )

    def node(self, root: bool = True, **node: object) -> int:
        index = self.add("nodes", node)
        if root:
            self.document["scenes"][0]["nodes"].append(index)
        return index

    def light(self, light: dict, **node: object) -> int:
        lights = self.document.setdefault("extensions", {}).setdefault(
            "KHR_lights_punctual", {"lights": []}
        )["lights"]
        lights.append(light)
        self.document["extensionsUsed"] = sorted(
            {*self.document.get("extensionsUsed", []), "KHR_lights_punctual"}
        )
        return self.node(extensions={"KHR_lights_punctual": {"light": len(lights) - 1}}, **node)

    def gltf(self) -> bytes:
        document = dict(self.document)
        if self.buffer:
            uri = "data:application/octet-stream;base64," + base64.b64encode(self.buffer).decode()
            document["buffers"] = [{"byteLength": len(self.buffer), "uri": uri}]
        return json.dumps(document).encode()

    def glb(self) -> bytes:
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        document = {**self.document, "buffers": [{"byteLength": len(self.buffer)}]}
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        return (
            struct.pack(
                "<4sIIII", b"glTF", 2, 28 + len(text) + len(self.buffer), len(text), 0x4E4F534A
            )
            + text
            + struct.pack("<II", len(self.buffer), 0x004E4942)
            + self.buffer
        )
