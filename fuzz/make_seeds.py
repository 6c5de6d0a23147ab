#!/usr/bin/env python3
"""Writes seeds for the fuzzers into FOLDER/ply, csv, config, materials, tool, index and gateway.

    make_seeds.py FOLDER

The seeds are small valid files and the table of broken inputs of the command line tests.
"""

import json
import os
import struct
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


CUT = b"\xfe"
POSE = {"header": {"seq": 1, "stamp": {"secs": 1, "nsecs": 2}, "frame_id": "world"},
        "pose": {"position": {"x": 0.1, "y": -2, "z": 3e-2}, "orientation": {"x": 0.6, "y": 0, "z": 0, "w": 0.8}}}
MESSAGES = (
    {"op": "subscribe", "id": "1", "topic": "/t", "type": "std_msgs/msg/String", "throttle_rate": 16,
     "queue_length": 2, "compression": "cbor"},
    {"op": "subscribe", "topic": "/l"},
    {"op": "advertise", "topic": "/i", "type": "geometry_msgs/PoseStamped"},
    {"op": "publish", "topic": "/i", "msg": POSE},
    {"op": "call_service", "service": "/s", "args": {"data": [True, None, 1.5], "text": "x", "number": 7}, "id": "2"},
    {"op": "call_service", "service": "/rosapi/topic_type", "args": {"topic": "/t"}},
    {"op": "call_service", "service": "/rosapi/services"},
    {"op": "set_level", "level": "none"},
    {"op": "unsubscribe", "topic": "/t", "id": "1"},
)


def cbor_head(major, n):
    for mark, (limit, code) in enumerate(((1 << 8, ">B"), (1 << 16, ">H"), (1 << 32, ">I"), (1 << 64, ">Q")), 24):
        if n < 24:
            return bytes([major << 5 | n])
        if n < limit:
            return bytes([major << 5 | mark]) + struct.pack(code, n)
    raise ValueError(n)


def cbor(value):
    """CBOR encoding of a value, as a browser's encoder writes it (RFC 8949)."""
    if value is None or isinstance(value, bool):
        return {False: b"\xf4", True: b"\xf5", None: b"\xf6"}[value]
    if isinstance(value, int):
        return cbor_head(0, value) if value >= 0 else cbor_head(1, -1 - value)
    if isinstance(value, float):
        return b"\xfb" + struct.pack(">d", value)
    if isinstance(value, str):
        return cbor_head(3, len(value.encode())) + value.encode()
    if isinstance(value, dict):
        return cbor_head(5, len(value)) + b"".join(cbor(part) for pair in value.items() for part in pair)
    return cbor_head(4, len(value)) + b"".join(map(cbor, value))


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
    # Changes to an index, see index_fuzzer.cpp: none, single bytes, a truncation; and a file with only a header.
    yield "index", b""
    yield "index", bytes([0, 0, 12, 2])
    yield "index", bytes([0, 16, 0, 255, 0, 80, 0, 255])
    yield "index", bytes([0, 32, 0])
    yield "index", b"PALPATE\n" + bytes([4, 3, 2, 1, 1, 0, 0, 0]) + bytes(8176)
    # Messages of clients, see gateway_fuzzer.cpp: text frames, CBOR frames, and heads of requests.
    yield "gateway", b"\0" + CUT.join(json.dumps(message).encode() for message in MESSAGES)
    for message in MESSAGES:
        yield "gateway", b"\0" + json.dumps(message).encode()
    yield "gateway", b"\1" + CUT.join(cbor(message) for message in MESSAGES)
    yield "gateway", b"\0" + b"[" * 33 + b"]" * 33
    yield "gateway", b"\1" + b"\x81" * 33 + b"\1" + CUT + b"\x9f\xff" + CUT + b"\xc1\0" + CUT + b"\xbb" + b"\xff" * 8
    yield "gateway", b"\2" + CUT.join((b"/a%20b?x=1&token=s3cret", b"127.0.0.1:9090", b"http://127.0.0.1:9090", b"", b"",
                                      b"bytes=0-499"))
    yield "gateway", b"\2" + CUT.join((b"/%2e%2e/a", b"[::1]", b"null", b"Bearer s3cret", b"a=b; palpate-9090=c00kie",
                                      b"bytes=-5"))
    yield "gateway", b"\2" + CUT.join((b"http://a/b#c", b"LOCALHOST:80", b"", b"Basic x", b"palpate=", b"bytes=1-,5-6"))


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
