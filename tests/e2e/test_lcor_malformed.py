# SPDX-License-Identifier: MIT
"""Scene files that are broken: a clear error soon, in bounded memory, whatever the bytes are."""

import json
import random
import resource
import struct

import pytest
from gltf_scene import QUAD, Scene, png
from lcor_run import SANITIZED, good, lcor, refused

# Whole processes, several libraries and threads' stacks included; nothing sanitized fits in it.
ADDRESS_SPACE = 1 << 30
PROCESSOR_SECONDS = 2  # some 0.4 of them load the libraries
ROUNDS = 16


def limit() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_SECONDS, PROCESSOR_SECONDS))


def honest() -> Scene:
    scene = Scene()
    picture = png(8, 8, bytes(range(192)))
    scene.node(mesh=scene.quad(material=scene.textured(picture)), scale=[2, 2, 1])
    scene.node(mesh=scene.quad([(x, y, 2) for x, y, _ in QUAD], material=scene.material()))
    scene.light({"type": "point", "intensity": 8.0}, translation=[0.5, 0.5, 1.0])
    camera = scene.add(
        "cameras", {"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}
    )
    scene.node(camera=camera, translation=[0.5, 0.5, 1.5])
    return scene


def places(value, path=()):
    """Every place in a document."""
    yield path
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from places(value[key], (*path, key))


def changed_document(rng: random.Random) -> bytes:
    """A scene one or two of whose values are wrong."""
    scene = honest()
    text = scene.gltf()
    for _ in range(rng.randint(1, 2)):
        document = json.loads(text)
        *folder, last = rng.choice([p for p in places(document) if p])
        holder = document
        for key in folder:
            holder = holder[key]
        wrong = [-1, 0, 7, 1e308, 2**31, 2**32 - 1, "x", None, [], {}, True, [1e300] * 3]
        if rng.random() < 0.2:
            del holder[last]
        else:
            holder[last] = rng.choice(wrong)
        text = json.dumps(document).encode()
    return text


def changed_bytes(rng: random.Random) -> bytes:
    """A binary scene with bytes changed, cut off or put in."""
    data = bytearray(honest().glb())
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(data))
        choice = rng.randrange(4)
        if choice == 0:
            data[at] ^= 1 << rng.randrange(8)
        elif choice == 1:
            del data[at : at + rng.choice((1, 4, 1000))]
        elif choice == 2:
            data[at:at] = rng.randbytes(4)
        else:
            data[at : at + 4] = struct.pack("<I", rng.choice((0, 2**31, 2**32 - 1)))
        if not data:
            break
    return bytes(data)


def changed_lines(rng: random.Random) -> bytes:
    words = ["v", "f", "vt", "1", "-1", "0", "1e308", "-1e-308", "nan", "9/9", "1//", "\\\n", "#"]
    lines = ["v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", "vt 0 0", "usemtl a", "f 1 2 3 4"]
    for _ in range(rng.randint(1, 6)):
        lines.insert(rng.randrange(len(lines)), " ".join(rng.choices(words, k=rng.randint(1, 9))))
    return "\n".join(lines).encode()


@pytest.mark.parametrize(
    ("make", "name"),
    [(changed_document, "s.gltf"), (changed_bytes, "s.glb"), (changed_lines, "s.obj")],
)
@pytest.mark.skipif(SANITIZED, reason="sanitizers take all addresses; fuzz targets run under them")
def test_broken_scenes_end_soon_and_say_why(tmp_path, make, name):
    rng = random.Random(name)
    refusals = 0
    for turn in range(ROUNDS):
        path = tmp_path / name
        path.write_bytes(make(rng))
        out = tmp_path / "o.png"
        render = ("render", path, "--contrast", 9, "--size", "16x9", "-o", out, "--threads", 1)
        tolerance = ("--tolerance", 0.3, "--max-seconds", 1, "--light", "0.5,0.5,1,5")
        run = lcor(*(("info", path) if turn % 2 else (*render, *tolerance)), preexec_fn=limit)
        assert run.returncode in (0, 3), (turn, run.returncode, run.stderr, path.read_bytes())
        errors = [line for line in run.stderr.splitlines() if "warning" not in line]
        if run.returncode == 3:
            assert len(errors) == 1 and name in errors[0], run.stderr
            assert not out.exists() or turn % 2
        refusals += run.returncode == 3
        out.unlink(missing_ok=True)
    assert refusals > ROUNDS // 10


def copies(tmp_path, count):
    """A file that places a mesh of 20,000 equal triangles that many times."""
    scene = Scene()
    many = scene.mesh(QUAD, [0, 1, 2] * 20000, material=scene.material())
    for _ in range(count):
        scene.node(mesh=many)
    path = tmp_path / "s.glb"
    path.write_bytes(scene.glb())
    return path


@pytest.mark.skipif(SANITIZED, reason="sanitizers take all addresses; fuzz targets run under them")
def test_instances_do_not_multiply_without_end(tmp_path):
    refused(3, "info", copies(tmp_path, 3000), says="more than", preexec_fn=limit)


@pytest.mark.skipif(SANITIZED, reason="sanitizers take all addresses; fuzz targets run under them")
def test_a_hundred_thousand_triangles_in_one_plane_are_taken_soon(tmp_path):
    good("info", copies(tmp_path, 5), preexec_fn=limit)


@pytest.mark.skipif(SANITIZED, reason="sanitizers take all addresses; fuzz targets run under them")
def test_a_scene_larger_than_memory_is_refused_before_it_is_read(tmp_path):
    scene = copies(tmp_path, 50)
    output = ("-o", tmp_path / "o.png", "--contrast", 9, "--light", "0.5,0.5,1,5")
    refused(3, "render", scene, *output, says="fewer, or place", preexec_fn=limit)
