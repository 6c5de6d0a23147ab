"""What a scene is made of: --materials, and the properties of a .ply."""

import os
import unittest

from support import INRIA, Case, ply, splat, tapping_path, wall_rows

TABLE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples", "materials", "table.toml")
REGION = "[[region]]\nstiffness = 900\n"


class Materials(Case):
    def setUp(self):
        super().setUp()
        self.write("a.ply", ply(wall_rows()))
        self.write("path.csv", tapping_path(50))
        self.write("m.toml", REGION)

    def test_every_command_that_feels_takes_them(self):
        self.succeed("query", "a.ply", "--pose", "0,0,0.02", "--materials", "m.toml")
        self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv", "--materials", "m.toml")
        self.succeed("bench", "a.ply", "--trajectory", "path.csv", "--rounds", "1", "--materials", "m.toml")
        self.write("c.toml", 'materials = "m.toml"')
        self.succeed("query", "a.ply", "--pose", "0,0,0.02", "--config", "c.toml")
        self.write("c.toml", 'materials = "no.toml"')
        self.refuse(1, "no.toml", "query", "a.ply", "--pose", "0,0,0.02", "--config", "c.toml")

    def test_other_models_do_not_read_them(self):
        for model in ("field", "density"):
            self.succeed("query", "a.ply", "--pose", "0,0,0.02", "--model", model, "--materials", "no.toml")

    def test_the_example_fits_the_table(self):
        self.succeed("make-scene", "table", "--spacing", "0.01", "--out", "table.ply", "-q")
        self.succeed("query", "table.ply", "--pose=-0.25,0.14,0.15", "--materials", TABLE)

    def test_info_names_the_properties_of_the_file(self):
        rows = [row + [500.0, float("nan")] for row in wall_rows(3)]
        self.write("hard.ply", ply(rows, INRIA + ["stiffness", "friction"]))
        self.assertIn(b"with stiffness, friction", self.succeed("info", "hard.ply").out)
        self.assertTrue(self.succeed("info", "hard.ply", "--json").json["format"].endswith("with stiffness, friction"))
        self.assertNotIn(b"stiffness", self.succeed("info", "a.ply").out)

    def test_properties_do_not_change_what_is_touched(self):
        self.write("hard.ply", ply([row + [500.0] for row in wall_rows()], INRIA + ["stiffness"]))
        query = ("--pose", "0,0,0.02", "--json", "--model", "field")
        self.assertEqual(self.succeed("query", "hard.ply", *query).figures, self.succeed("query", "a.ply", *query).figures)

    def test_a_broken_property_is_found_whether_there_is_an_index_or_not(self):
        self.write("bad.ply", ply([splat() + [0.5], splat() + [-1.0]], INRIA + ["friction"]))
        for _ in range(2):
            self.refuse(1, ["bad.ply", "Gaussian 1", "'friction'"], "query", "bad.ply", "--pose", "0,0,0")


if __name__ == "__main__":
    unittest.main()
