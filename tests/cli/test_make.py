"""Made scenes and paths: every shape, and the same bytes for the same seed."""

import math
import tomllib
import unittest

from support import Case, columns_of, head_of, ply, ply_header, table_of, wall_rows

SHAPES = ["sphere", "plane", "box", "cylinder", "torus", "step", "shell", "table"]


class MakeScene(Case):
    def make(self, shape, name, *args):
        self.succeed("make-scene", shape, "--out", name, "-q", *args)
        return self.read(name)

    def test_every_shape_can_be_made_and_read(self):
        for shape in SHAPES:
            with self.subTest(shape):
                result = self.succeed("make-scene", shape, "--out", "s.ply", "--spacing", "0.02")
                self.assertIn("s.ply", result.out.decode())
                info = self.succeed("info", "s.ply", "--json").json
                self.assertGreater(info["gaussians"], 100)
                self.assertEqual(sum(info["lint"][k] for k in ("nan", "infinite", "zero_quaternion", "zero_scale")), 0)
                self.assertGreater(info["filter"]["kept"], 0.9 * info["gaussians"])

    def test_the_header_is_inrias(self):
        data = self.make("sphere", "s.ply", "--spacing", "0.02")
        lines = data.split(b"end_header\n")[0].split(b"\n")
        count = int(next(line for line in lines if line.startswith(b"element")).split()[-1])
        expected = ply_header(count)
        uncommented = b"\n".join(line for line in lines if not line.startswith(b"comment ")) + b"end_header\n"
        self.assertEqual(uncommented, expected)
        self.assertEqual(len(data.split(b"end_header\n", 1)[1]), count * 17 * 4)

    def test_a_still_life_tells_its_materials(self):
        self.make("still-life", "s.ply", "--spacing", "0.008")
        info = self.succeed("info", "s.ply")
        self.assertIn("with stiffness, friction, damping", info.out.decode())
        stroke = self.succeed("query", "s.ply", "--pose", "0.2,-0.22,0.005", "--tool", "0.008,0.008,0.008", "--json").json
        self.assertGreater(len(stroke["contacts"]), 0)
        self.assertGreater(stroke["force"][2], 0.5)
        first = self.make("still-life", "a.ply", "--spacing", "0.012", "--seed", "7")
        self.assertEqual(first, self.make("still-life", "b.ply", "--spacing", "0.012", "--seed", "7"))

    def test_a_seed_decides_every_byte(self):
        args = ["--spacing", "0.02", "--noise", "0.001", "--tilt", "10"]
        for shape in SHAPES:
            first = self.make(shape, "a.ply", *args, "--seed", "7")
            self.assertEqual(first, self.make(shape, "b.ply", *args, "--seed", "7"), shape)
            self.assertNotEqual(first.split(b"end_header\n")[1],
                                self.make(shape, "b.ply", *args, "--seed", "8").split(b"end_header\n")[1], shape)

    def test_a_made_sphere_is_felt_where_it_is(self):
        self.make("sphere", "s.ply", "--seed", "3")
        outside = self.succeed("query", "s.ply", "--pose", "0,0,0.2", "--json").json
        self.assertEqual(outside["contacts"], [])
        touching = self.succeed("query", "s.ply", "--pose", "0,0,0.185", "--json").json
        self.assertGreater(len(touching["contacts"]), 3)
        self.assertGreater(touching["force"][2], 0)  # pushed out, up
        self.assertLess(math.hypot(*touching["force"][:2]), touching["force"][2])

    def test_what_captures_have_wrong_can_be_made(self):
        count = {}
        for like in ("", "floaters", "holes", "double", "holes,double"):
            self.make("plane", "s.ply", "--spacing", "0.01", *(["--like", like] if like else []))
            count[like] = self.succeed("info", "s.ply", "--json").json["gaussians"]
        self.assertEqual(count[""], 1600)
        self.assertEqual(count["floaters"], 1632)
        self.assertEqual(count["double"], 3200)
        self.assertAlmostEqual(count["holes"], 1440, delta=60)
        self.assertAlmostEqual(count["holes,double"], 2880, delta=120)
        self.refuse(2, "--like", "make-scene", "plane", "--out", "s.ply", "--like", "dust")

    def test_impossible_wishes(self):
        for args in (["--spacing", "0"], ["--spacing", "-1"], ["--noise", "-1"], ["--tilt", "91"], ["--seed", "x"],
                     ["--seed", "-1"], ["--spacing", "nan"]):
            self.refuse(2, args[0], "make-scene", "sphere", "--out", "s.ply", *args)
        self.refuse(1, "Gaussians", "make-scene", "sphere", "--out", "s.ply", "--spacing", "1e-6")
        self.assertEqual(self.files(), [])


class MakePath(Case):
    def test_a_path_touches_and_can_be_replayed(self):
        self.succeed("make-scene", "sphere", "--out", "s.ply", "-q")
        result = self.succeed("make-path", "s.ply", "--touches", "2", "--out", "p.csv")
        self.assertIn("2 touches", result.out.decode())
        first = self.read("p.csv")
        path = columns_of(first)
        self.assertEqual(list(path), "t x y z qw qx qy qz".split(" "))
        times = [float(t) for t in path["t"]]
        self.assertEqual(times, sorted(set(times)))
        summary = self.succeed("replay", "s.ply", "--trajectory", "p.csv", "--out", "r.csv", "--json").json
        self.assertEqual(summary["episodes"], 2)
        self.assertGreater(summary["force_max"], 0)
        self.succeed("make-path", "s.ply", "--touches", "2", "--out", "q.csv", "-q")
        self.assertEqual(table_of(first), table_of(self.read("q.csv")))

    def test_a_path_says_how_it_was_made(self):
        self.write("wall.ply", ply(wall_rows()))
        self.succeed("make-path", "wall.ply", "--touches", "2", "--seed", "5", "--sigma", "1.5", "--tool", "0.01,0.01,0.01", "--out", "p.csv", "-q")
        head = tomllib.loads(head_of(self.read("p.csv")))
        self.assertEqual((head["made"]["command"], head["made"]["scene"]), ("make-path", "wall.ply"))
        self.assertRegex(head["made"]["scene-checksum"], "^xxh3-16MiB:[0-9a-f]{16}$")
        settings = head["settings"]
        self.assertEqual([settings[name] for name in ("scene", "sigma", "tool", "touches", "seed")],
                         ["wall.ply", 1.5, [0.01, 0.01, 0.01], 2, 5])
        self.assertLess({"press", "slide", "rate"}, set(settings))

    def test_the_number_of_touches_is_told_as_it_is(self):
        self.write("wall.ply", ply(wall_rows(11)))  # 10 cm: too small for 40 places
        text = self.succeed("make-path", "wall.ply", "--touches", "40", "--rate", "200", "--out", "p.csv").out.decode()
        summary = self.succeed("replay", "wall.ply", "--trajectory", "p.csv", "--out", "r.csv", "--json").json
        self.assertLess(summary["episodes"], 40)
        self.assertIn(f"{summary['episodes']} touches", text)

    def test_a_seed_changes_the_path(self):
        self.succeed("make-scene", "sphere", "--out", "s.ply", "-q")
        for seed in "12":
            self.succeed("make-path", "s.ply", "--touches", "1", "--seed", seed, "--out", f"p{seed}.csv", "-q")
        self.assertNotEqual(table_of(self.read("p1.csv")), table_of(self.read("p2.csv")))

    def test_nowhere_to_touch(self):
        self.write("wall.ply", ply(wall_rows(3)))
        result = self.run_palpate("make-path", "wall.ply", "--opacity-min", "1", "--out", "p.csv")
        self.assertEqual(result.code, 1)
        self.assertNotIn("p.csv", self.files())

    def test_the_scene_is_not_overwritten(self):
        self.write("wall.ply", ply(wall_rows()))
        before = self.read("wall.ply")
        self.refuse(1, "wall.ply", "make-path", "wall.ply", "--out", "wall.ply")
        self.assertEqual(self.read("wall.ply"), before)


if __name__ == "__main__":
    unittest.main()
