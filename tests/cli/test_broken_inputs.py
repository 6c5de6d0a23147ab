"""Every row of broken_inputs.py: refused as specified, in one sane line, without litter, quickly."""

import os
import subprocess
import unittest

from broken_inputs import ROWS
from support import SANITIZED, Case, RUN_HEADER, path_csv, ply, refusal_problem, splat

MAX_SECONDS = 5.0
MAX_MB = 300.0
INDEX = b"a.ply.palpate"


class BrokenInputs(Case):
    def setUp(self):
        super().setUp()
        self.sound = {
            "a.ply": ply([splat(0.01 * k) for k in range(20)]),
            "path.csv": path_csv([(0, 0, 0, 0.02), (1, 0, 0, 0.01)]).encode(),
            "run.csv": (RUN_HEADER + "\n" + ",".join(["0"] * 4 + ["1"] + ["0"] * 17) + "\n").encode(),
        }
        for name, content in self.sound.items():
            self.write(name, content)

    def problem_with(self, row):
        folder = os.fsencode(self.folder)
        files = {os.fsencode(name): content for name, content in row.files.items()}
        for name, content in files.items():
            with open(os.path.join(folder, name), "wb") as file:
                file.write(content)
        expected = sorted([*map(os.fsencode, self.sound), *files])
        result = self.run_palpate(*row.args, timeout=60)
        found = sorted(os.listdir(folder))
        for name in found:
            if name not in map(os.fsencode, self.sound):
                os.remove(os.path.join(folder, name))
        if INDEX in found:  # of the sound scene; test_index.py is about it
            found.remove(INDEX)
        problem = refusal_problem(result, row.code, row.words)
        if problem:
            return problem
        if found != expected:
            return f"leaves {set(found) - set(expected)} behind"
        if any(self.read(name) != content for name, content in self.sound.items()):
            return "changed an input"
        if not SANITIZED and result.seconds > MAX_SECONDS:
            return f"took {result.seconds:.1f} s"
        if not SANITIZED and result.peak_mb > MAX_MB:
            return f"took {result.peak_mb:.0f} MB"
        return None

    def test_table(self):
        self.assertGreater(len(ROWS), 60)
        self.assertEqual(len({row.name for row in ROWS}), len(ROWS), "names are unique")
        for row in ROWS:
            with self.subTest(row.name):
                problem = self.problem_with(row)
                if problem:
                    self.fail(problem)

    def test_a_fifo_is_not_waited_for(self):
        os.mkfifo(self.path("fifo.ply"))
        for args in (["info", "fifo.ply"], ["replay", "a.ply", "--trajectory", "fifo.ply", "--out", "r.csv"],
                     ["query", "a.ply", "--pose", "0,0,0", "--config", "fifo.ply"], ["report", "fifo.ply", "--out", "r"]):
            self.refuse(1, ["fifo.ply", "regular file"], *args, timeout=10)

    @unittest.skipIf(os.geteuid() == 0, "root reads everything")
    def test_an_unreadable_file(self):
        self.write("secret.ply", self.sound["a.ply"])
        os.chmod(self.path("secret.ply"), 0)
        self.refuse(1, ["secret.ply", "Permission denied"], "info", "secret.ply")

    def test_warnings_keep_control_characters_from_the_terminal(self):
        for name in ("a\x1b[31m.ply", "a\nb.ply", "a\u009b31m.ply"):
            self.write(name, ply([splat()]))
            result = self.succeed("query", name, "--pose", "0,0,0", "--opacity-min", "1", "-q")
            text = result.err.decode()
            self.assertEqual(text.count("\n"), 1)
            self.assertFalse([c for c in text[:-1] if ord(c) < 0x20 or 0x7F <= ord(c) < 0xA0], repr(text))
            shown = self.succeed("info", name).out.decode()
            self.assertFalse([c for c in shown if c not in "\n" and (ord(c) < 0x20 or 0x7F <= ord(c) < 0xA0)], repr(shown))
            self.assertEqual(self.succeed("info", name, "--json").json["file"], name)

    @unittest.skipUnless(os.geteuid() == 0, "mounting needs root")
    def test_a_disk_that_fills_up(self):
        disk = self.path("disk")
        os.mkdir(disk)
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", disk], capture_output=True).returncode:
            self.skipTest("no mounts here")
        self.addCleanup(subprocess.run, ["umount", disk])
        self.write("long.csv", path_csv([(k, 0, 0, 0.02) for k in range(2000)]))
        self.write("disk/run.csv", b"precious")
        for args in (["replay", "a.ply", "--trajectory", "long.csv", "--out", "disk/run.csv"],
                     ["make-scene", "sphere", "--out", "disk/run.csv"]):
            self.refuse(1, ["disk/run.csv", "No space left"], *args)
            self.assertEqual(os.listdir(disk), ["run.csv"])
            self.assertEqual(self.read("disk/run.csv"), b"precious")


if __name__ == "__main__":
    unittest.main()
