"""The index file beside a scene: made, used, made again when it does not fit, and never in the way."""

import json
import os
import pty
import subprocess
import unittest

from support import PALPATE, Case, columns_of, ply, random_rows, tapping_path, wall_rows

INDEX = "a.ply.palpate"


class Index(Case):
    def setUp(self):
        super().setUp()
        self.write("a.ply", ply(wall_rows() + random_rows(400, 3)))
        self.write("path.csv", tapping_path(200))

    def listing(self):
        return sorted(os.listdir(self.folder))

    def state(self):
        """Changes whenever the file is written anew."""
        status = os.stat(self.path(INDEX))
        return status.st_ino, status.st_mtime_ns, status.st_size

    def query(self, *args):
        """The document of a query in contact, and what is said about the index."""
        result = self.succeed("query", "a.ply", "--pose", "0.01,0.02,0.03", "--json", *args)
        self.assertGreater(len(result.json["contacts"]), 5)
        notes = [line for line in result.err.decode().splitlines() if INDEX in line]
        return result.figures, notes

    def replay(self, *args):
        self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv", "-q", *args)
        columns = columns_of(self.read("run.csv"))
        del columns["compute_us"]
        self.assertGreater(sum(int(n) > 0 for n in columns["colliding"]), 50)
        return columns

    def test_query_makes_it_and_uses_it(self):
        without, notes = self.query("--no-index-file")
        self.assertEqual(notes, [])
        self.assertNotIn(INDEX, self.listing())
        first, notes = self.query()
        self.assertEqual(notes, [])
        self.assertEqual(self.listing(), ["a.ply", INDEX, "path.csv"])
        before = self.state()
        second, notes = self.query()
        self.assertEqual(notes, [])
        self.assertEqual(self.state(), before)
        self.assertEqual(json.dumps(first), json.dumps(without))
        self.assertEqual(json.dumps(second), json.dumps(without))

    def test_replay_makes_it_and_uses_it(self):
        without = self.replay("--no-index-file")
        self.assertNotIn(INDEX, self.listing())
        self.assertEqual(self.replay(), without)
        before = self.state()
        self.assertEqual(self.replay(), without)
        self.assertEqual(self.replay("--threads", "1"), without)
        self.query()
        self.assertEqual(self.state(), before)

    def test_it_does_not_depend_on_where_the_scene_is_put(self):
        self.query()
        before = self.state()
        moved = ["--translate", "0.5,0,0", "--rotate", "0,0,0,1", "--scale", "2"]
        result = self.succeed("query", "a.ply", "--pose", "0.5,0,0.05", "--json", *moved)
        alone = self.succeed("query", "a.ply", "--pose", "0.5,0,0.05", "--json", "--no-index-file", *moved)
        self.assertGreater(len(result.json["contacts"]), 0)
        self.assertEqual(result.figures, alone.figures)
        self.assertEqual(self.state(), before)

    def on_a_terminal(self, *args):
        """What palpate says on stderr when that is a terminal."""
        ours, its = pty.openpty()
        command = [PALPATE, "query", "a.ply", "--pose", "0,0,0", "--json", *args]
        subprocess.run(command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=its, check=True)
        os.close(its)
        text = b""
        try:
            while more := os.read(ours, 4096):
                text += more
        except OSError:  # the other end is closed
            pass
        os.close(ours)
        return text.decode()

    def test_a_person_is_told_that_it_was_made(self):
        self.assertIn("note: wrote " + INDEX, self.on_a_terminal())
        self.assertNotIn(INDEX, self.on_a_terminal())
        os.remove(self.path(INDEX))
        self.assertEqual(self.on_a_terminal("-q"), "")
        self.assertIn(INDEX, self.listing())

    def test_other_options_make_it_again_and_say_so(self):
        self.query()
        before = self.state()
        document, notes = self.query("--sigma", "2")
        self.assertIn("other options", notes[0])
        self.assertIn("--sigma 1", notes[0])
        self.assertNotEqual(self.state(), before)
        self.assertEqual(document, self.query("--sigma", "2", "--no-index-file")[0])
        self.assertEqual(self.query("--sigma", "2")[1], [])

    def test_a_changed_scene_makes_it_again(self):
        self.query()
        self.write("a.ply", ply(wall_rows() + random_rows(400, 4)))
        document, notes = self.query()
        self.assertIn("stale", notes[0])
        self.assertEqual(document, self.query("--no-index-file")[0])

    def test_a_touched_scene_does_not(self):
        self.query()
        before = self.state()
        os.utime(self.path("a.ply"), (1, 1))
        self.assertEqual(self.query()[1], [])
        self.assertEqual(self.state(), before)

    def test_a_damaged_one_is_made_again(self):
        truth = self.query()[0]
        sound = self.read(INDEX)
        middle = len(sound) // 2
        flipped = sound[:middle] + bytes([sound[middle] ^ 1]) + sound[middle + 1:]
        for damaged in (b"", b"PALPATE\n", sound[:middle], flipped, bytes(len(sound)), self.read("a.ply")):
            self.write(INDEX, damaged)
            document, notes = self.query()
            self.assertTrue(notes[0].startswith("palpate: note: " + INDEX), notes)
            self.assertIn("rebuilt", notes[0])
            self.assertEqual(document, truth)
            self.assertEqual(self.read(INDEX), sound)

    def test_without_it_neither_reads_nor_writes(self):
        self.write(INDEX, b"not a palpate index")
        self.assertEqual(self.query("--no-index-file")[1], [])
        self.assertEqual(self.read(INDEX), b"not a palpate index")
        self.write("c.toml", "no-index-file = true\n")
        self.assertEqual(self.query("--config", "c.toml")[1], [])
        self.assertEqual(self.read(INDEX), b"not a palpate index")

    def test_other_commands_leave_none(self):
        self.succeed("info", "a.ply")
        self.replay("--pipeline", "paper", "--search-radius", "0.2")
        self.succeed("report", "run.csv", "--scene", "a.ply", "--out", "page.html")
        self.succeed("make-scene", "sphere", "--out", "s.ply")
        self.succeed("make-path", "s.ply", "--touches", "1", "--out", "touch.csv")
        self.assertFalse([name for name in self.listing() if name.endswith(".palpate")])

    def test_a_read_only_folder_is_warned_of(self):
        truth = self.query("--no-index-file")[0]
        os.chmod(self.folder, 0o555)
        self.addCleanup(os.chmod, self.folder, 0o755)
        before = self.listing()
        for _ in range(2):
            document, notes = self.query()
            self.assertTrue(notes[0].startswith("palpate: warning: " + INDEX), notes)
            self.assertEqual(document, truth)
        self.assertEqual(self.listing(), before)

    def test_one_in_a_read_only_folder_is_used(self):
        truth = self.query()[0]
        os.chmod(self.folder, 0o555)
        self.addCleanup(os.chmod, self.folder, 0o755)
        document, notes = self.query()
        self.assertEqual((document, notes), (truth, []))

    def test_a_broken_scene_leaves_none(self):
        self.write("a.ply", self.read("a.ply")[:-5])
        self.refuse(1, "a.ply", "query", "a.ply", "--pose", "0,0,0")
        self.assertEqual(self.listing(), ["a.ply", "path.csv"])

    def test_many_processes_may_make_it_at_once(self):
        truth = self.query("--no-index-file")[0]
        command = [PALPATE, "query", "a.ply", "--pose", "0.01,0.02,0.03", "--json", "-q"]
        for _ in range(5):
            children = [subprocess.Popen(command, cwd=self.folder, stdout=subprocess.PIPE) for _ in range(4)]
            for child in children:
                out, _ = child.communicate(timeout=60)
                self.assertEqual(child.returncode, 0)
                told = json.loads(out)
                del told["made"]
                self.assertEqual(told, truth)
            self.assertEqual(self.listing(), ["a.ply", INDEX, "path.csv"])
            os.remove(self.path(INDEX))


if __name__ == "__main__":
    unittest.main()
