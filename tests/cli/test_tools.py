"""Tools of many ellipsoids: --tool FILE.toml."""

import json
import os
import unittest

from support import Case, columns_of, path_csv, ply, wall_rows
from test_report import Page

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples", "tools")
BALL = '[[ellipsoid]]\nname = "{}"\nsemi_axes = [0.02, 0.02, 0.02]\nposition = [{}, 0.0, 0.0]\n'
PAIR = BALL.format("left", -0.05) + BALL.format("right", 0.05)
MODELS = ("proxy", "field", "density")


class Tools(Case):
    def setUp(self):
        super().setUp()
        self.write("a.ply", ply(wall_rows()))
        self.write("path.csv", path_csv([(k / 1000, 0, 0, 0.03 - k / 5000) for k in range(100)]))
        self.write("pair.toml", PAIR)

    def query(self, tool, pose, *args):
        return self.succeed("query", "a.ply", "--pose", pose, "--tool", tool, "--json", *args).figures

    def test_an_ellipsoid_in_a_file_is_the_one_of_three_numbers(self):
        self.write("one.toml", '[[ellipsoid]]\nname = "tool"\nsemi_axes = [0.01, 0.02, 0.03]\n')
        for model in MODELS:
            self.assertEqual(self.query("one.toml", "0,0,0.02", "--model", model),
                             self.query("0.01,0.02,0.03", "0,0,0.02", "--model", model))

    def test_contacts_are_those_of_the_parts(self):
        both = self.query("pair.toml", "0.01,0.02,0.015")["contacts"]
        for name, x in (("left", -0.04), ("right", 0.06)):
            alone = self.query("0.02,0.02,0.02", f"{x},0.02,0.015")["contacts"]
            self.assertGreater(len(alone), 5)
            of_part = [contact for contact in both if contact["part"] == name]
            self.assertEqual(sorted(c["id"] for c in of_part), sorted(c["id"] for c in alone))
            for contact in of_part:
                self.assertTrue(0.0 <= contact["confidence"] <= 1.0)
        self.assertEqual({contact["part"] for contact in both}, {"left", "right"})

    def test_torque_is_about_the_handle(self):
        # Of the two balls only the left one is above the wall, whose edge is at x = 0.1: up at -x turns about +y.
        for model in MODELS:
            answer = self.query("pair.toml", "0.14,0,0.015", "--model", model)
            self.assertGreater(answer["force"][2], 0)
            self.assertGreater(answer["torque"][1], 0)

    def test_replay_report_and_bench_take_them(self):
        self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv", "--tool", "pair.toml", "-q")
        run = columns_of(self.read("run.csv"))
        self.assertGreater(max(map(int, run["colliding"])), 0)
        self.succeed("report", "run.csv", "--scene", "a.ply", "--tool", "pair.toml", "--out", "r.html", "-q")
        tool = json.loads(Page(self.read("r.html").decode()).document)["tool"]
        self.assertEqual([part["name"] for part in tool], ["left", "right"])
        self.assertEqual([part["position"] for part in tool], [[-0.05, 0, 0], [0.05, 0, 0]])
        figures = self.succeed("bench", "a.ply", "--trajectory", "path.csv", "--rounds", "1", "--tool", "pair.toml",
                               "--json").json
        self.assertEqual(figures["tool"], tool)

    def test_replay_has_the_contacts_and_forces_of_query(self):
        self.write("still.csv", path_csv([(0, 0.01, 0.02, 0.015)]))
        self.succeed("replay", "a.ply", "--trajectory", "still.csv", "--out", "run.csv", "--tool", "pair.toml", "-q")
        run, answer = columns_of(self.read("run.csv")), self.query("pair.toml", "0.01,0.02,0.015")
        self.assertEqual(int(run["colliding"][0]), len(answer["contacts"]))
        for k, name in enumerate(("fx", "fy", "fz")):
            self.assertAlmostEqual(float(run[name][0]), answer["force"][k], places=9)

    def test_make_path_leads_them_to_the_scene(self):
        self.succeed("make-scene", "sphere", "--out", "s.ply", "-q")
        self.write("tool.toml", PAIR.replace("0.05", "0.01"))
        self.succeed("make-path", "s.ply", "--touches", "3", "--tool", "tool.toml", "--out", "p.csv", "-q")
        self.succeed("replay", "s.ply", "--trajectory", "p.csv", "--tool", "tool.toml", "--out", "run.csv", "-q")
        self.assertGreater(max(map(int, columns_of(self.read("run.csv"))["colliding"])), 0)

    def test_a_configuration_may_name_one(self):
        self.write("c.toml", 'tool = "pair.toml"')
        self.assertEqual(self.succeed("query", "a.ply", "--pose", "0,0,0.015", "--config", "c.toml", "--json").figures,
                         self.query("pair.toml", "0,0,0.015"))

    def test_every_example_feels_the_wall(self):
        for name in sorted(os.listdir(EXAMPLES)):
            with self.subTest(name):
                answer = self.query(os.path.join(EXAMPLES, name), "0,0,0.001")
                self.assertGreater(len(answer["contacts"]), 0)


if __name__ == "__main__":
    unittest.main()
