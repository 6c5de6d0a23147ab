"""Outputs appear whole or not at all, and never where they would destroy something."""

import os
import resource
import signal
import subprocess
import time
import unittest

from support import PALPATE, SANITIZED, Case, ply, random_rows, table_of, tapping_path, wall_rows


class Output(Case):
    def setUp(self):
        super().setUp()
        self.write("a.ply", ply(wall_rows()))
        self.write("path.csv", tapping_path(50))
        self.inputs = self.files()

    def replay(self, out, *args):
        return ["replay", "a.ply", "--trajectory", "path.csv", "--out", out, "-q", *args]

    def assert_inputs_only(self):
        self.assertEqual(self.files(), self.inputs)

    def test_an_input_is_never_the_output(self):
        self.write("c.toml", "sigma = 1\n")
        self.succeed(*self.replay("run.csv"))
        os.symlink("a.ply", self.path("link.ply"))
        os.link(self.path("path.csv"), self.path("hard.csv"))
        before = {name: self.read(name) for name in self.files()}
        for out, args in {
            "a.ply": self.replay("a.ply"),
            "path.csv": self.replay("path.csv"),
            "./a.ply": self.replay("./a.ply"),
            "link.ply": self.replay("link.ply"),
            "hard.csv": self.replay("hard.csv"),
            "c.toml": self.replay("c.toml", "--config", "c.toml"),
            "run.csv": ["report", "run.csv", "--out", "run.csv"],
            "a.ply ": ["report", "run.csv", "--scene", "a.ply", "--out", "a.ply"],
            "c.toml ": ["report", "run.csv", "--config", "c.toml", "--out", "c.toml"],
            " a.ply": ["make-path", "a.ply", "--out", "a.ply"],
            " c.toml": ["make-scene", "sphere", "--config", "c.toml", "--out", "c.toml"],
        }.items():
            with self.subTest(args):
                try:
                    self.refuse(1, out.strip(), *args)
                    changed = [name for name in self.files() if self.read(name) != before.get(name)]
                    self.assertEqual(changed, [])
                finally:
                    for name, content in before.items():
                        self.write(name, content)

    def test_a_failure_leaves_an_earlier_output_alone(self):
        self.write("run.csv", "precious")
        self.write("bad.csv", "t,x,y,z\n0,0,0,0\n1,0,0,zero\n")
        self.refuse(1, "bad.csv", "replay", "a.ply", "--trajectory", "bad.csv", "--out", "run.csv")
        self.refuse(1, "missing.ply", "replay", "missing.ply", "--trajectory", "path.csv", "--out", "run.csv")
        self.refuse(2, "--sigma", *self.replay("run.csv", "--sigma", "-1"))
        self.write("run.html", "precious")
        self.refuse(1, "bad.csv", "report", "bad.csv", "--out", "run.html")
        for name in ("run.csv", "run.html"):
            self.assertEqual(self.read(name), b"precious")

    def test_an_earlier_output_is_replaced_whole(self):
        self.write("run.csv", "x" * 1_000_000)
        self.succeed(*self.replay("run.csv"))
        self.assertTrue(table_of(self.read("run.csv")).startswith("t,x,"))
        self.assertNotIn(b"xxx", self.read("run.csv"))

    def test_an_output_has_the_permissions_of_any_new_file(self):
        self.succeed(*self.replay("run.csv"))
        mask = os.umask(0)
        os.umask(mask)
        self.assertEqual(os.stat(self.path("run.csv")).st_mode & 0o777, 0o666 & ~mask)

    def test_a_symbolic_link_is_followed(self):
        os.mkdir(self.path("there"))
        self.write("there/run.csv", "old")
        os.symlink("there/run.csv", self.path("run.csv"))
        self.succeed(*self.replay("run.csv"))
        self.assertTrue(os.path.islink(self.path("run.csv")))
        self.assertTrue(table_of(self.read("there/run.csv")).startswith("t,x,"))
        self.assertEqual(os.listdir(self.path("there")), ["run.csv"])

    def test_a_symbolic_link_to_nothing_yet_is_followed(self):
        os.mkdir(self.path("there"))
        os.symlink("there/run.csv", self.path("run.csv"))
        self.succeed(*self.replay("run.csv"))
        self.assertTrue(os.path.islink(self.path("run.csv")))
        self.assertTrue(table_of(self.read("there/run.csv")).startswith("t,x,"))

    def test_other_names_for_an_output(self):
        os.mkdir(self.path("there"))
        self.succeed(*self.replay("there/../there/run.csv"))
        self.succeed(*self.replay(self.path("absolute.csv")))
        self.succeed(*self.replay("with space and ünïcode.csv"))
        self.succeed(*self.replay("no-extension"))
        self.assertEqual(os.listdir(self.path("there")), ["run.csv"])
        self.assertEqual(self.files(),
                         sorted([*self.inputs, "there", "absolute.csv", "with space and ünïcode.csv", "no-extension"]))

    def test_places_that_cannot_be_written(self):
        os.mkdir(self.path("folder"))
        self.inputs = self.files()
        self.refuse(1, ["missing/run.csv", "No such file"], *self.replay("missing/run.csv"))
        self.refuse(1, ["folder", "is a folder"], *self.replay("folder"))
        self.refuse(1, "a.ply/run.csv", *self.replay("a.ply/run.csv"))
        self.refuse(1, ["/proc/run.csv", "cannot"], *self.replay("/proc/run.csv"))
        self.refuse(1, "File name too long", *self.replay("n" * 300 + ".csv"))
        result = self.run_palpate(*self.replay(""))
        self.assertIn(result.code, (1, 2))
        self.assert_inputs_only()

    @unittest.skipIf(os.geteuid() == 0, "root may write anywhere")
    def test_a_read_only_folder(self):
        os.mkdir(self.path("locked"), 0o500)
        self.refuse(1, ["locked/run.csv", "Permission denied"], *self.replay("locked/run.csv"))

    def test_a_dash_is_no_file(self):
        self.refuse(1, ["-: ", "/dev/stdout"], *self.replay("-"))
        self.refuse(1, ["-: ", "/dev/stdout"], "make-scene", "sphere", "--out", "-", "-q")
        self.refuse(1, ["-: ", "/dev/stdout"], "run", "a.ply", "--record", "-", "--seconds", "0.1", "-q", "--port", "0")
        self.assert_inputs_only()
        self.succeed(*self.replay("./-"))

    def test_a_page_or_picture_ends_in_its_format(self):
        self.succeed(*self.replay("run.csv"))
        for name in ("r.pdf", "r.svg", "r.HTM"):
            self.refuse(1, [name, ".html"], "report", "run.csv", "--out", name)
        self.refuse(1, ["h.png", ".svg"], "bench", "a.ply", "--histogram", "h.png")
        self.refuse(1, ["p.pdf", ".html"], "evaluate", "--html", "p.pdf")
        self.assertNotIn("h.png", self.files())

    def test_a_full_disk(self):
        self.refuse(1, ["/dev/full", "No space left"], *self.replay("/dev/full"))
        self.refuse(1, "No space left", "make-scene", "sphere", "--out", "/dev/full", "-q")
        self.succeed(*self.replay("run.csv"))
        self.refuse(1, "No space left", "report", "run.csv", "--out", "/dev/full")

    def test_a_full_standard_output(self):
        for args in (["query", "a.ply", "--pose", "0,0,0", "--json"], ["info", "a.ply"], ["info", "a.ply", "--json"],
                     ["--version"], ["--help"], ["query", "--help"], ["completion", "bash"]):
            self.refuse(1, "No space left", *args, stdout="/dev/full")

    def test_a_limit_on_the_file_size(self):
        """What a full disk does in the middle of a large file: EFBIG stands in for ENOSPC."""
        self.write("long.csv", tapping_path(20000))

        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, 1 << 20))

        self.write("run.csv", "precious")
        before = self.files()
        result = subprocess.run(
            [PALPATE, "replay", "a.ply", "--trajectory", "long.csv", "--out", "run.csv", "-q"], cwd=self.folder,
            preexec_fn=limit, restore_signals=False, capture_output=True)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn(b"run.csv: cannot write: File too large", result.stderr)
        self.assertEqual(self.read("run.csv"), b"precious")
        self.assertEqual(self.files(), before)

    def test_a_pipe_is_written_through(self):
        script = '"$0" replay a.ply --trajectory path.csv --out /dev/stdout -q | cat > copied.csv'
        subprocess.run(["bash", "-c", script, PALPATE], cwd=self.folder, check=True)
        copied = self.read("copied.csv")
        self.assertTrue(table_of(copied).startswith("t,x,"))
        self.assertEqual(table_of(copied).count("\n"), 51)

    def test_a_kill_leaves_nothing(self):
        count = 10_000 if SANITIZED else 100_000
        self.write("a.ply", ply(wall_rows(41) + random_rows(500, 1)))
        self.write("path.csv", tapping_path(count))
        self.write("run.csv", "precious")
        before = self.files()
        for delay in (0.02, 0.1, 0.3, 0.6, 1.0):
            process = subprocess.Popen([PALPATE, *self.replay("run.csv")], cwd=self.folder)
            time.sleep(delay)
            process.send_signal(signal.SIGKILL)
            killed = process.wait() == -signal.SIGKILL
            self.assertEqual(self.files(), before)
            run = self.read("run.csv")
            if killed:
                self.assertTrue(run == b"precious" or table_of(run).count("\n") == count + 1)


if __name__ == "__main__":
    unittest.main()
