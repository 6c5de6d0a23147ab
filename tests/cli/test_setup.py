"""palpate setup, and what palpate info proposes: options that make an unknown scene one that can be felt."""

import tomllib
import unittest

from support import Case, head_of


class Setup(Case):
    def setUp(self):
        super().setUp()
        self.succeed("make-scene", "table", "--spacing", "0.004", "--out", "table.ply", "-q")

    def propose(self, *args, scene="table.ply"):
        """The proposals, and how they were made."""
        told = self.succeed("setup", scene, "--json", *args).json
        return told, told.pop("made")

    def test_proposes_what_a_person_would_choose(self):
        self.succeed("make-scene", "still-life", "--out", "still.ply", "-q")
        proposed, _ = self.propose(scene="still.ply")
        self.assertEqual(proposed["frame"]["value"], "z-up")
        self.assertEqual(proposed["opacity_min"]["value"], 0.3)  # nothing of it is thin
        self.assertIsNone(proposed["max_scale"]["value"])
        self.assertIsNone(proposed["crop_box"]["value"])
        for proposal in proposed.values():
            self.assertGreater(len(proposal["reason"]), 10)

    def test_leaves_what_is_the_same_upside_down_as_it_is(self):
        for shape in ("plane", "step", "cylinder", "torus"):
            self.succeed("make-scene", shape, "--out", "shape.ply", "-q")
            proposed, _ = self.propose(scene="shape.ply")
            self.assertEqual(proposed["frame"]["value"], "as-is")
            self.assertIn("the up direction is ambiguous", proposed["frame"]["reason"])

    def test_proposes_to_drop_what_info_calls_giant(self):
        self.succeed("make-scene", "box", "--like", "tails", "--like", "haze", "--out", "box.ply", "-q")
        told = self.succeed("info", "box.ply", "--json").json
        self.assertGreater(told["lint"]["giant"], 0)
        largest = str(told["proposed"]["max_scale"]["value"])
        scale = str(told["proposed"]["scale"]["value"])
        kept = self.succeed("info", "box.ply", "--json", "--scale", scale, "--max-scale", largest).json["filter"]
        self.assertGreaterEqual(kept["over_max_scale"] + kept["low_opacity"], told["lint"]["giant"])
        self.assertGreater(kept["over_max_scale"], 0)

    def test_a_smaller_tool_gets_a_smaller_scene(self):
        large, _ = self.propose("--tool", "0.02,0.03,0.04")
        small, _ = self.propose("--tool", "0.002,0.03,0.04")
        self.assertAlmostEqual(large["scale"]["value"] / small["scale"]["value"], 10, delta=0.5)

    def test_info_says_the_same(self):
        proposed, _ = self.propose()
        self.assertEqual(self.succeed("info", "table.ply", "--json").json["proposed"], proposed)
        text = self.succeed("info", "table.ply").out.decode()
        self.assertIn(f"--opacity-min {proposed['opacity_min']['value']}", text)
        self.assertIn(proposed["scale"]["reason"], text)

    def test_the_file_is_one_for_every_command(self):
        proposed, _ = self.propose("--out", "table.toml")
        info = self.succeed("info", "table.ply", "--config", "table.toml", "--json").json
        self.assertEqual(info["filter"]["opacity_min"], proposed["opacity_min"]["value"])
        by_hand = self.succeed("info", "table.ply", "--json", "--frame", "z-up", "--scale", str(proposed["scale"]["value"]),
                               "--opacity-min", "0.3").json
        self.assertEqual(info["world_bounds"], by_hand["world_bounds"])

    def test_says_how_it_was_made(self):
        _, made = self.propose("--tool", "0.01,0.02,0.03", "--out", "table.toml")
        self.assertEqual((made["command"], made["scene"]), ("setup", "table.ply"))
        self.assertEqual(made["settings"], {"scene": "table.ply", "tool": [0.01, 0.02, 0.03]})
        head = tomllib.loads(head_of(self.read("table.toml")))
        self.assertEqual((head["made"]["scene-checksum"], head["settings"]), (made["scene_checksum"], made["settings"]))
        told = self.succeed("info", "table.ply", "--opacity-min", "0.2", "--json").json["made"]
        self.assertEqual((told["command"], told["scene_checksum"], told["settings"]["opacity-min"]),
                         ("info", made["scene_checksum"], 0.2))

    def test_the_options_may_be_pasted(self):
        first = self.succeed("setup", "table.ply").out.decode().splitlines()[0]
        self.succeed("info", "table.ply", *first.split()[1:])

    def test_bad_usage(self):
        self.refuse(1, "missing.ply", "setup", "missing.ply")
        self.refuse(1, "table.ply", "setup", "table.ply", "--out", "table.ply")
        self.refuse(2, "SCENE", "setup")


if __name__ == "__main__":
    unittest.main()
