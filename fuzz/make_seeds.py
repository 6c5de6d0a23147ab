#!/usr/bin/env python3
"""Writes seeds for the fuzzers into FOLDER/ply, csv, config, materials, tool and index.

    make_seeds.py FOLDER

The seeds are small sound files and the table of broken inputs of the command line tests.
"""

import os
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
sys.path.insert(0, os.path.join(ROOT, "tests", "cli"))

import broken_inputs  # noqa: E402
from support import INRIA, LIVE_HEADER, RUN_HEADER, path_csv, ply, random_rows, splat  # noqa: E402

MAX_BYTES = 8192
FOLDERS = {".ply": ["ply"], ".splat": ["ply"], ".csv": ["csv"], ".toml": ["config", "materials", "tool"]}

LISTS = (
    b"ply\nformat ascii 1.0\ncomment c\nobj_info o\nelement face 2\nproperty list uchar int vertex_indices\n"
    b"element vertex 1\n" + b"".join(b"property double %s\n" % name.encode() for name in broken_inputs.BARE) +
    b"property float filter_3D\nelement edge 1\nproperty short s\nend_header\n3 0 1 2\n0\n"
    b"500000.123 5400000 1 2 -4 -4 -4 1 0 0 0 0.01\n7\n")


def sound_files():
    rows = random_rows(3, 1)
    for encoding in ("ascii", "binary_little_endian", "binary_big_endian"):
        yield "ply", ply(rows, encoding=encoding)
    yield "ply", ply(rows, kind="double")
    yield "ply", ply([splat()[:15] + splat()[16:]], [name for name in INRIA if name != "scale_2"])
    yield "ply", ply([splat() + [0.1] * 9], INRIA + [f"f_rest_{k}" for k in range(9)])
    yield "ply", LISTS
    for encoding in ("ascii", "binary_big_endian"):
        yield "ply", ply([splat() + [500, float("nan"), 2]] * 2, INRIA + ["stiffness", "friction", "damping"], encoding)
    yield "ply", bytes(range(64))  # two records of a .splat
    yield "csv", path_csv([(0, 0, 0, 1), (0.5, 1e-3, -2, 3)]).encode()
    yield "csv", path_csv([(0, 0, 0, 1, 1, 0, 0, 0, 4, 5, 6)], "t,x,y,z,qw,qx,qy,qz,ufx,ufy,ufz").encode()
    yield "csv", (RUN_HEADER + "\r\n" + ",".join(["0"] * 4 + ["1"] + ["2"] * 17) + "\r\n").encode()
    yield "csv", (RUN_HEADER + LIVE_HEADER + "\n" + ("1," * 31 + "4,10" + ",0" * 5 + "\n") + "2,0").encode()
    yield "config", (b'# options\nsigma = 1.5\ntool = [0.01, 0.02, 0.03]\njson = true\nframe = "y-up"\n'
                     b"[table]\na.b = {c = 1, d = 1979-05-27T07:32:00Z}\n'x y' = '''\nz'''\n")
    with open(os.path.join(ROOT, "examples", "materials", "table.toml"), "rb") as file:
        yield "materials", file.read()
    for name in ("stylus", "gripper"):
        with open(os.path.join(ROOT, "examples", "tools", name + ".toml"), "rb") as file:
            yield "tool", file.read()
    # Changes to an index, see index_fuzzer.cpp: none, a byte of each part, a cut; and one that is only a front.
    yield "index", b""
    yield "index", bytes([0, 0, 12, 2])
    yield "index", bytes([0, 16, 0, 255, 0, 80, 0, 255])
    yield "index", bytes([0, 32, 0])
    yield "index", b"PALPATE\n" + bytes([4, 3, 2, 1, 1, 0, 0, 0]) + bytes(8176)


def main():
    seeds = list(sound_files())
    for row in broken_inputs.ROWS:
        for name, content in row.files.items():
            folders = FOLDERS.get(os.path.splitext(name)[1], []) if isinstance(name, str) else []
            if len(content) <= MAX_BYTES:
                seeds.extend((folder, content) for folder in folders)
    for k, (folder, content) in enumerate(seeds):
        path = os.path.join(sys.argv[1], folder)
        os.makedirs(path, exist_ok=True)
        with open(os.path.join(path, f"seed-{k}"), "wb") as file:
            file.write(content)


if __name__ == "__main__":
    main()
