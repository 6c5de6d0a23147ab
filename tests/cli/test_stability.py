"""palpate stability: figures that say what they say, and the same every time."""

import unittest
from xml.etree import ElementTree

from support import SANITIZED, Case, table_of

KEYS = ["profile", "hand", "model", "hold_ms", "worker_ms", "limit_cycle_mm", "port_energy_mj", "contact_changes",
        "rest_force", "slide_force_off", "fault", "z_width"]
FIGURES = ["cycle", "energy", "trace", "z-width", "wall"]
SMALL = ["--profiles", "omega", "--hands", "0.15,3,400", "--places", "1"]


class Stability(Case):
    def rows(self, *args):
        return self.succeed("stability", *SMALL, "--json", *args).json["rows"]

    def test_rows_are_as_documented(self):
        rows = self.rows()
        walls = [row for row in rows if row["model"] == "wall"]
        held = [row for row in rows if row["model"] != "wall"]
        self.assertEqual([(row["model"], row["worker_ms"], row["hold_ms"]) for row in held],
                         [(model, worker, hold) for model in ("proxy", "field", "density")
                          for worker, hold in ((0, 0), (50, 0), (0, 50))])
        for row in held:
            self.assertEqual(list(row), KEYS)
            self.assertEqual(row["hand"], [0.15, 3, 400])
            self.assertEqual(row["z_width"] is None, row["model"] == "density")
        self.assertEqual([row["passivity"] for row in walls], [False, True])

    def test_proxy_and_field_rest_and_are_passive_however_late_the_worker(self):
        for row in self.rows("--models", "proxy,field"):
            if row["model"] == "wall" or row["hold_ms"]:
                continue
            self.assertLessEqual(row["limit_cycle_mm"], 0.05)
            self.assertLessEqual(row["port_energy_mj"], 1.0)
            self.assertLessEqual(row["slide_force_off"], 0.05)
            self.assertGreater(row["rest_force"], 0.5)
            self.assertEqual(row["fault"], "none")
            self.assertGreater(row["z_width"], 500)

    def test_a_swing_that_dies_away_is_no_limit_cycle(self):
        heavy = ["--hands", "0.3,1,100", "--places", "1", "--profiles", "omega", "--delay", "0", "--json"]
        for row in self.succeed("stability", *heavy, "--models", "field", "--stiffness", "3000").json["rows"]:
            if row["model"] == "field":
                self.assertLess(row["limit_cycle_mm"], 0.01)
                self.assertGreater(row["z_width"], 10000)

    def test_a_force_that_is_held_swings(self):
        for row in self.rows("--models", "proxy,field"):
            if row.get("hold_ms"):
                self.assertGreater(row["limit_cycle_mm"], 5)
                self.assertGreater(row["port_energy_mj"], 10)

    def test_the_wall_is_as_stiff_as_theory_lets_it_be(self):
        for row in self.rows("--models", "density", "--delay", "0", "--profiles", "touch,falcon"):
            if row["model"] == "wall":
                self.assertAlmostEqual(row["z_width"] / row["z_width_bound"], 1.0, delta=0.1, msg=row)

    def test_is_the_same_every_time(self):
        args = ["--models", "proxy", "--delay", "0"]
        self.assertEqual(self.rows(*args), self.rows(*args))

    def test_files_have_the_same_figures(self):
        self.succeed("stability", *SMALL, "--models", "field", "--csv", "t.csv", "--html", "p.html", "--svg", ".")
        self.assertEqual(self.files(), sorted(["t.csv", "p.html"] + [f"stability-{name}.svg" for name in FIGURES]))
        lines = table_of(self.read("t.csv")).splitlines()
        self.assertEqual(len(lines), 1 + 3)
        self.assertEqual(lines[0].split(",")[:2], ["profile", "hand_mass"])
        page = self.read("p.html").decode()
        self.assertEqual(page.count("<svg"), len(FIGURES))
        self.assertNotIn("http://", page.replace("http://www.w3.org", ""))
        for name in FIGURES:
            ElementTree.fromstring(self.read(f"stability-{name}.svg"))

    def test_bad_usage(self):
        for option, value in (("--profiles", "phantom"), ("--hands", "1,2"), ("--hands", "1,2,-3"), ("--places", "0"),
                              ("--delay", "1"), ("--models", "soft")):
            self.refuse(2, option, "stability", option, value)
        self.refuse(1, "missing.ply", "stability", "missing.ply")
        self.refuse(1, "nowhere", "stability", "--csv", "nowhere/t.csv")


if __name__ == "__main__":
    unittest.main()
