"""palpate setup, and what palpate info proposes: options that make an unknown scene one that can be felt."""

import unittest

from support import Case


class Setup(Case):
    def setUp(self):
        super().setUp()
        self.succeed("make-scene", "table", "--spacing", "0.004", "--out", "table.ply", "-q")

    def test_proposes_what_a_person_would_choose(self):
        proposed = self.succeed("setup", "table.ply", "--json").json
        self.assertEqual(proposed["frame"]["value"], "z-up")
        self.assertEqual(proposed["opacity_min"]["value"], 0.3)  # nothing of it is thin
        self.assertIsNone(proposed["crop_box"]["value"])
        for proposal in proposed.values():
            self.assertGreater(len(proposal["reason"]), 10)

    def test_a_smaller_tool_gets_a_smaller_scene(self):
        large = self.succeed("setup", "table.ply", "--json", "--tool", "0.02,0.03,0.04").json["scale"]["value"]
        small = self.succeed("setup", "table.ply", "--json", "--tool", "0.002,0.03,0.04").json["scale"]["value"]
        self.assertAlmostEqual(large / small, 10, delta=0.5)

    def test_info_says_the_same(self):
        proposed = self.succeed("setup", "table.ply", "--json").json
        self.assertEqual(self.succeed("info", "table.ply", "--json").json["proposed"], proposed)
        text = self.succeed("info", "table.ply").out.decode()
        self.assertIn("--frame z-up", text)
        self.assertIn(proposed["scale"]["reason"], text)

    def test_the_file_is_one_for_every_command(self):
        proposed = self.succeed("setup", "table.ply", "--out", "table.toml", "--json").json
        info = self.succeed("info", "table.ply", "--config", "table.toml", "--json").json
        self.assertEqual(info["filter"]["opacity_min"], proposed["opacity_min"]["value"])
        by_hand = self.succeed("info", "table.ply", "--json", "--frame", "z-up", "--scale", str(proposed["scale"]["value"]),
                               "--opacity-min", "0.3").json
        self.assertEqual(info["world_bounds"], by_hand["world_bounds"])

    def test_the_options_may_be_pasted(self):
        first = self.succeed("setup", "table.ply").out.decode().splitlines()[0]
        self.succeed("info", "table.ply", *first.split()[1:])

    def test_bad_usage(self):
        self.refuse(1, "missing.ply", "setup", "missing.ply")
        self.refuse(1, "table.ply", "setup", "table.ply", "--out", "table.ply")
        self.refuse(2, "SCENE", "setup")


if __name__ == "__main__":
    unittest.main()
