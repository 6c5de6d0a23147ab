"""Replay is deterministic: the same bytes every time, on any number of threads."""

import os
import shutil
import tomllib
import unittest

from support import Case, columns_of, head_of, path_csv, ply, random_rows, tapping_path, wall_rows


def without_time(run):
    columns = columns_of(run)
    times = columns.pop("compute_us")
    assert all(float(t) > 0 for t in times)
    return columns


class Determinism(Case):
    def setUp(self):
        super().setUp()
        self.write("a.ply", ply(wall_rows() + random_rows(400, 3)))
        self.write("path.csv", tapping_path(5000, 5000.0))

    def replay(self, *args):
        self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv", "-q", *args)
        return without_time(self.read("run.csv"))

    def test_runs_and_threads_change_nothing_but_the_time(self):
        first = self.replay()
        self.assertGreater(sum(int(n) > 0 for n in first["colliding"]), 1000)
        for threads in (None, 1, 2, 4):
            self.assertEqual(first, self.replay(*(["--threads", str(threads)] if threads else [])))

    def test_further_columns_may_hold_anything(self):
        first = self.replay()
        lines = self.read("path.csv").decode().splitlines()
        cells = ["one", "", "nan", "-", "2"]
        others = [f"{cells[k % 5]},{line},{cells[(k + 1) % 5]}" for k, line in enumerate(lines[1:])]
        self.write("path.csv", "\n".join(["note," + lines[0] + ",by", *others]))
        self.assertEqual(first, self.replay())
        self.write("path.csv", "t,x,y,z,qw,qx,qy,qz,by\n0,0,0,1,1,0,0,0,me\n1,0,nan,1,1,0,0,0,me\n")
        self.refuse(1, ["line 3", "'y'", "nan"], "replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv")

    def test_so_is_the_papers_pipeline(self):
        args = ["--pipeline", "paper", "--search-radius", "0.2"]
        first = self.replay(*args)
        self.assertEqual(first, self.replay(*args, "--threads", "2"))
        exact = self.replay()
        self.assertEqual(first["colliding"], exact["colliding"])
        self.assertNotEqual(first["candidates"], exact["candidates"])

    def test_the_papers_pipeline_reports_what_it_can_miss(self):
        result = self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv", "--json",
                              "--pipeline", "paper", "--search-radius", "0.05")
        self.assertEqual(result.json["search_radius"], 0.05)
        self.assertGreater(result.json["can_miss"], 0)
        text = self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv",
                            "--pipeline", "paper", "--search-radius", "0.05").out.decode()
        self.assertIn(f"{result.json['can_miss']} Gaussians reach beyond the search radius", text)


def turning_path(count=300):
    """Into wall_rows() and along it while the tool turns, with quaternions that are rounded."""
    poses = []
    for k in range(count):
        q = (0.9, 0.002 * k, -0.1, 0.3)
        norm = sum(c * c for c in q) ** 0.5
        poses.append((k / 1000, 0.0002 * k - 0.03, 0.01, 0.03 - 0.0001 * min(k, 200), *(round(c / norm, 6) for c in q)))
    return path_csv(poses, "t,x,y,z,qw,qx,qy,qz")


HAND = """[[ellipsoid]]
name = "tip"
semi_axes = [0.01, 0.012, 0.02]
orientation = [0.9, 0.1, -0.2, 0.33]
[[ellipsoid]]
name = "rod"
semi_axes = [0.008, 0.008, 0.04]
position = [0.0, 0.01, 0.03]
"""


class From(Case):
    """A run says how it was made, and is made again from what it says."""

    OPTIONS = ["--opacity-min", "0.15", "--sigma", "1.25", "--rotate", "0.7,0.1,-0.2,0.3", "--scale", "1.1", "--translate",
               "0.01,0,0.003", "--tool", "hand.toml", "--stiffness", "731.3", "--friction", "0.3"]

    def setUp(self):
        super().setUp()
        self.write("a.ply", ply(wall_rows() + random_rows(400, 3)))
        self.write("path.csv", turning_path())
        self.write("hand.toml", HAND)

    def replay(self, *args, out="run.csv"):
        self.succeed("replay", *args, "--out", out, "-q")
        return self.read(out)

    def head(self, run):
        return tomllib.loads(head_of(run))

    def elsewhere(self, *names):
        """Takes these files, and nothing else, to another folder, where palpate runs from now on."""
        there = self.path("elsewhere/data")
        os.makedirs(there)
        for name in names:
            shutil.copy(self.path(name), there)
        self.folder = there

    def test_a_run_says_how_it_was_made(self):
        head = self.head(self.replay("a.ply", "--trajectory", "path.csv", *self.OPTIONS))
        made, settings = head["made"], head["settings"]
        self.assertEqual((made["command"], made["scene"]), ("replay", "a.ply"))
        self.assertRegex(made["version"], r"^\d+\.\d+\.\d+$")
        self.assertRegex(made["scene-checksum"], r"^xxh3-16MiB:[0-9a-f]{16}$")
        self.assertIn("cores", made["machine"])
        self.assertEqual((settings["opacity-min"], settings["stiffness"], settings["model"]), (0.15, 731.3, "proxy"))
        self.assertEqual([part["name"] for part in tomllib.loads(settings["tool"])["ellipsoid"]], ["tip", "rod"])

    def test_json_says_the_same(self):
        self.write("j.toml", "")
        told = self.succeed("replay", "a.ply", "--trajectory", "path.csv", *self.OPTIONS, "--out", "run.csv", "--json").json["made"]
        head = self.head(self.read("run.csv"))
        self.assertEqual(told.pop("settings"), head["settings"])
        self.assertEqual({name.replace("_", "-"): value for name, value in told.items()}, head["made"])

    def test_a_run_is_repeated_to_the_last_bit_from_its_own_file(self):
        for model in (["--model", "proxy"], ["--model", "field"], ["--model", "density"],
                      ["--pipeline", "paper", "--search-radius", "0.07"], ["--pipeline", "paper"]):
            with self.subTest(model=model):
                folder = self.folder
                first = self.replay("a.ply", "--trajectory", "path.csv", *self.OPTIONS, *model)
                self.assertGreater(max(int(n) for n in columns_of(first)["colliding"]), 5)
                self.elsewhere("a.ply", "run.csv")
                again = self.replay("a.ply", "--from", "run.csv", out="again.csv")
                self.assertEqual(without_time(again), without_time(first))
                self.assertEqual(self.head(again)["settings"]["search-radius"] if "--pipeline" in model else None,
                                 self.head(first)["settings"].get("search-radius"))
                third = self.replay("a.ply", "--from", "again.csv", out="third.csv")
                self.assertEqual(without_time(third), without_time(first))
                self.folder = folder
                shutil.rmtree(self.path("elsewhere"))

    def test_the_scene_is_found_where_it_was(self):
        first = self.replay("a.ply", "--trajectory", "path.csv")
        self.assertEqual(without_time(self.replay("--from", "run.csv", out="again.csv")), without_time(first))

    def test_a_scene_that_has_moved_must_be_named(self):
        self.replay("a.ply", "--trajectory", "path.csv")
        os.rename(self.path("a.ply"), self.path("b.ply"))
        self.refuse(1, ["run.csv", "a.ply", "replay SCENE --from"], "replay", "--from", "run.csv", "--out", "again.csv")
        self.replay("b.ply", "--from", "run.csv", out="again.csv")

    def test_another_scene_is_refused(self):
        self.replay("a.ply", "--trajectory", "path.csv")
        self.write("a.ply", ply(wall_rows() + random_rows(400, 4)))
        for scene in ([], ["a.ply"]):
            self.refuse(1, ["run.csv", "another scene than a.ply", "xxh3-16MiB:", "--trajectory run.csv"], "replay", *scene,
                        "--from", "run.csv", "--out", "again.csv")
        self.assertFalse(os.path.exists(self.path("again.csv")))

    def test_materials_are_held_to_what_they_were(self):
        self.write("m.toml", '[[region]]\nname = "soft"\nsphere = { center = [0, 0, 0], radius = 1 }\nstiffness = 200\n')
        result = self.run_palpate("replay", "a.ply", "--trajectory", "path.csv", "--materials", "m.toml", "--out", "run.csv", "-q")
        self.assertEqual(result.code, 0, result.err)
        self.replay("--from", "run.csv", out="again.csv")
        self.write("m.toml", '[[region]]\nname = "soft"\nsphere = { center = [0, 0, 0], radius = 1 }\nstiffness = 201\n')
        self.refuse(1, ["other materials", "m.toml"], "replay", "--from", "run.csv", "--out", "again.csv")

    def test_an_option_changes_what_it_says_and_nothing_else(self):
        self.replay("a.ply", "--trajectory", "path.csv", *self.OPTIONS)
        changed = self.head(self.replay("--from", "run.csv", "--stiffness", "300", out="again.csv"))["settings"]
        before = self.head(self.read("run.csv"))["settings"]
        self.assertEqual(changed.pop("stiffness"), 300)
        before.pop("stiffness")
        self.assertEqual(changed, before)
        self.replay("--from", "run.csv", "--iso", "0.2", out="again.csv")  # which sigma cannot go with
        self.assertEqual(self.head(self.read("again.csv"))["settings"]["iso"], 0.2)

    def test_a_run_that_does_not_say_is_refused(self):
        run = self.replay("a.ply", "--trajectory", "path.csv")
        self.write("bare.csv", run[run.index(b"t,x,"):])
        self.refuse(1, ["bare.csv", "has no record of how it was made"], "replay", "--from", "bare.csv", "--out", "again.csv")
        self.write("odd.csv", b"# no toml at all\n" + run[run.index(b"t,x,"):])
        self.refuse(1, "odd.csv: line 1", "replay", "--from", "odd.csv", "--out", "again.csv")
        self.write("new.csv", run.replace(b"# stiffness =", b"# elasticity ="))
        self.refuse(1, ["new.csv: line", "elasticity"], "replay", "--from", "new.csv", "--out", "again.csv")
        self.write("wild.csv", run.replace(b"# opacity-min = 0.1", b"# opacity-min = 7"))
        self.refuse(1, ["wild.csv: line", "opacity-min"], "replay", "--from", "wild.csv", "--out", "again.csv")
        self.refuse(1, "no.csv", "replay", "--from", "no.csv", "--out", "again.csv")
        self.replay("a.ply", "--trajectory", "bare.csv", out="again.csv")  # it is a trajectory all the same

    def test_a_run_is_not_written_over(self):
        before = self.replay("a.ply", "--trajectory", "path.csv")
        self.refuse(1, "run.csv", "replay", "--from", "run.csv", "--out", "run.csv")
        self.assertEqual(self.read("run.csv"), before)

    def test_without_a_scene_or_a_run_there_is_nothing_to_replay(self):
        self.refuse(2, ["SCENE", "--from"], "replay", "--trajectory", "path.csv", "--out", "run.csv")


if __name__ == "__main__":
    unittest.main()
