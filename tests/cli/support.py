"""What the tests of the command line share: running palpate, and input files made byte by byte."""

import csv
import io
import itertools
import json
import os
import random
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import unittest
from dataclasses import dataclass

PALPATE = os.path.abspath(os.environ.get("PALPATE", "palpate"))
SANITIZED = os.environ.get("PALPATE_SANITIZED") == "1"

RUN_HEADER = (
    "t,x,y,z,qw,qx,qy,qz,candidates,filtered,colliding,k_max,fx,fy,fz,tx,ty,tz,px,py,pz,compute_us"
)
LIVE_HEADER = ",vx,vy,vz,wx,wy,wz,sfx,sfy,sfz,stx,sty,stz,state,fault,energy,stored,damping,margin,age_us"
COMMANDS = ["info", "setup", "query", "replay", "report", "make-scene", "make-path", "bench", "evaluate", "run", "stability",
            "completion"]


@dataclass
class Result:
    code: int  # negative: killed by that signal
    out: bytes
    err: bytes
    seconds: float
    peak_mb: float

    @property
    def json(self):
        return json.loads(self.out)

    @property
    def figures(self):
        """The same without how it was made, which has the time of day."""
        return {name: value for name, value in self.json.items() if name != "made"}


def run(*args, cwd=None, timeout=120, stdout=None, env=None):
    """Runs palpate. Arguments may be bytes. `stdout` is a path to write to instead of capturing."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        start = time.monotonic()
        target = open(stdout, "wb") if stdout else out
        process = subprocess.Popen(
            [PALPATE, *args], cwd=cwd, stdin=subprocess.DEVNULL, stdout=target, stderr=err,
            env={**os.environ, **(env or {})})
        if stdout:
            target.close()
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - start > timeout:
                process.kill()
                os.wait4(process.pid, 0)
                process.returncode = -9
                raise AssertionError(f"palpate {args!r} still ran after {timeout} s")
            time.sleep(0.001)
        process.returncode = os.waitstatus_to_exitcode(status)
        seconds = time.monotonic() - start
        out.seek(0)
        err.seek(0)
        return Result(process.returncode, out.read(), err.read(), seconds, usage.ru_maxrss / 1024)


def stood_still(summary):
    """For how long the machine gave the servo thread of a run nothing. Unit: [us]."""
    return max(summary["late_us"]["max"], summary["tick_us"]["max"])


def threads_of(pid):
    """The name of each thread of a process, by its number."""
    names = {}
    for thread in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{thread}/comm", encoding="utf-8") as name:
            names[int(thread)] = name.read().strip()
    return names


def stop(process):
    """Sends SIGSTOP and waits until every thread stands still, which takes a busy machine a while."""
    process.send_signal(signal.SIGSTOP)

    def runs(thread):
        with open(f"/proc/{process.pid}/task/{thread}/stat", encoding="utf-8") as stat:
            return stat.read().rpartition(")")[2].split()[0] != "T"

    while any(runs(thread) for thread in threads_of(process.pid)):
        time.sleep(0.001)


def faults_but_late(summary):
    """The faults of a run without late ticks, which are the machine's where it is busy."""
    return [fault for fault in summary["faults"] if fault != "late-tick"]


class Case(unittest.TestCase):
    """A test in an empty folder of its own, which is also where palpate runs."""

    maxDiff = 2000

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="palpate-cli-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, content):
        mode = "wb" if isinstance(content, bytes) else "w"
        with open(self.path(name), mode) as file:
            file.write(content)
        return name

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def files(self):
        """What is in the folder, but for the index that a command leaves beside a scene (see test_index.py)."""
        return sorted(name for name in os.listdir(self.folder) if not name.endswith(".palpate"))

    def run_palpate(self, *args, **kwargs):
        return run(*args, cwd=self.folder, **kwargs)

    def succeed(self, *args, **kwargs):
        result = self.run_palpate(*args, **kwargs)
        self.assertEqual(result.code, 0, (args, result.err))
        return result

    def refuse(self, code, words, *args, **kwargs):
        """palpate must fail with this exit code and one line on stderr that contains `words`."""
        result = self.run_palpate(*args, **kwargs)
        problem = refusal_problem(result, code, words)
        self.assertIsNone(problem, f"{args!r}: {problem}")
        return result


def refusal_problem(result, code, words):
    """What is wrong with the way palpate refused, or None."""
    err = result.err
    text = err.decode("utf-8", "replace")
    if b"Sanitizer" in err or b"runtime error" in err:
        return f"a sanitizer speaks: {text[:2000]}"
    if result.code != code:
        return f"exit code {result.code}, not {code}: {text[:500]!r}"
    if result.out:
        return f"stdout has {result.out[:200]!r}"
    if not err.startswith(b"palpate: ") or not err.endswith(b"\n") or err.count(b"\n") != 1:
        return f"stderr is not one line of palpate's: {text[:500]!r}"
    if len(err) > 500:
        return f"the message has {len(err)} bytes: {text[:200]!r}..."
    if any(ord(c) < 0x20 or 0x7F <= ord(c) < 0xA0 for c in text[:-1]):
        return f"control characters reach the terminal: {text!r}"
    if "internal error" in text:
        return f"not meant for people: {text!r}"
    for word in [words] if isinstance(words, str) else words:
        if word not in text:
            return f"does not say {word!r}: {text!r}"
    return None


# --- scenes -------------------------------------------------------------------------------------

INRIA = ("x y z nx ny nz f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 "
         "rot_0 rot_1 rot_2 rot_3").split()
_FORMATS = {"binary_little_endian": "<", "binary_big_endian": ">"}


def splat(x=0.0, y=0.0, z=0.0, opacity=2.0, scale=(-4.0, -4.0, -4.0), rot=(1.0, 0.0, 0.0, 0.0)):
    """A row in INRIA's layout; opacity is a logit, scale is log sigma."""
    return [x, y, z, 0, 0, 0, 0.5, 0.0, -0.5, opacity, *scale, *rot]


def ply_header(count, properties=INRIA, encoding="binary_little_endian", kind="float"):
    lines = ["ply", f"format {encoding} 1.0", f"element vertex {count}"]
    lines += [f"property {kind} {name}" for name in properties]
    return ("\n".join(lines) + "\nend_header\n").encode()


def ply(rows, properties=INRIA, encoding="binary_little_endian", kind="float"):
    """The bytes of a .ply file."""
    header = ply_header(len(rows), properties, encoding, kind)
    if encoding == "ascii":
        return header + "".join(" ".join(repr(v) for v in row) + "\n" for row in rows).encode()
    pattern = _FORMATS[encoding] + str(len(properties)) + ("f" if kind == "float" else "d")
    return header + b"".join(struct.pack(pattern, *row) for row in rows)


def random_rows(count, seed, spread=0.15):
    """Gaussians of all shapes, orientations and opacities around the origin."""
    r = random.Random(seed)
    return [
        splat(*(r.uniform(-spread, spread) for _ in range(3)), opacity=r.uniform(-3, 4),
              scale=[r.uniform(-6.5, -3.2) for _ in range(3)],
              rot=[r.gauss(0, 1) * 3 for _ in range(4)])
        for _ in range(count)
    ]


def wall_rows(n=21, spacing=0.01):
    """A flat wall of splats in the plane z = 0."""
    half = n // 2
    return [splat(spacing * (i - half), spacing * (j - half), 0.0, scale=(-4.8, -4.8, -9.0))
            for i in range(n) for j in range(n)]


def path_csv(poses, header="t,x,y,z"):
    return header + "\n" + "".join(",".join(repr(float(v)) for v in pose) + "\n" for pose in poses)


def tapping_path(count=400, rate=1000.0):
    """Goes in and out of wall_rows() twice while sliding along it."""
    poses = []
    for k in range(count):
        phase = 2 * k / count % 1.0
        depth = 0.02 * (1 - 4 * abs(phase - 0.5))
        poses.append((k / rate, 0.05 * k / count, -0.02, 0.045 - depth))
    return path_csv(poses)


def head_of(csv_bytes):
    """How a table was made: the TOML in its comment, as text."""
    lines = csv_bytes.decode().split("\n")
    return "".join(line[2:] + "\n" for line in itertools.takewhile(lambda line: line.startswith("#"), lines))


def table_of(csv_bytes):
    """A table without its comment, as text."""
    lines = csv_bytes.decode().split("\n")
    return "\n".join(itertools.dropwhile(lambda line: line.startswith("#"), lines))


def rows_of(csv_bytes):
    """The rows of a table as {column: text}, also of one that is being written, whose last line may not be whole."""
    text = table_of(csv_bytes)
    return list(csv.DictReader(io.StringIO(text[: text.rindex("\n") + 1])))


def columns_of(csv_bytes):
    """A run as {column: [text]}."""
    lines = table_of(csv_bytes).split("\n")
    assert lines[-1] == "", "the last line is not ended"
    names = lines[0].split(",")
    rows = [line.split(",") for line in lines[1:-1]]
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}
