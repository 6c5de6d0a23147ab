"""docs/columns.md is what `palpate columns` prints, and names every column and field that commands write, and no other."""

import os
import pathlib
import re
import unittest

from support import RUN_HEADER, LIVE_HEADER, Case, path_csv, ply, random_rows, table_of, tapping_path, wall_rows

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/columns.md"
REACH = ["search_radius", "can_miss"]  # of the paper's pipeline alone
AMOUNTS = ["--scenes", "1", "--places", "2", "--pushes", "2"]


def sections(page):
    """{heading: [name]} of the tables of the page."""
    found = {}
    for part in page.split("\n## ")[1:]:
        heading, _, text = part.partition("\n")
        found[heading.replace("`", "")] = re.findall(r"^\| `([^`]+)` \|", text, re.MULTILINE)
    return found


def paths(value, told, prefix=""):
    """The fields of a document; what is told as a whole is not gone into."""
    if prefix in told or not isinstance(value, (dict, list)) or not value:
        return {prefix}
    if isinstance(value, list):
        return set().union(*(paths(item, told, prefix + "[]") for item in value)) if isinstance(value[0], dict) else {prefix}
    return set().union(*(paths(item, told, f"{prefix}.{name}" if prefix else name) for name, item in value.items()))


class Columns(Case):
    @classmethod
    def setUpClass(cls):
        cls.told = sections(PAGE.read_text())

    def setUp(self):
        super().setUp()
        self.write("a.ply", ply(wall_rows() + random_rows(100, 5)))
        self.write("path.csv", tapping_path(100))

    def assert_told(self, heading, *args, may_lack=()):
        """The fields of --json are those of the page."""
        fields = paths(self.succeed(*args, "--json").json, set(self.told[heading]))
        self.assertEqual(fields - set(self.told[heading]), set(), heading)
        self.assertEqual(set(self.told[heading]) - fields - set(may_lack), set(), heading)

    def assert_columns(self, heading, name):
        self.assertEqual(table_of(self.read(name)).split("\n")[0].split(","), self.told[heading])

    def test_the_page_is_current(self):
        self.assertEqual(self.succeed("columns").out.decode(), PAGE.read_text(), "palpate columns > docs/columns.md")

    def test_the_command_is_for_the_page_alone(self):
        self.assertNotIn(b"columns", self.succeed("--help").out)

    def test_runs_and_trajectories(self):
        user_force = ",ufx,ufy,ufz"
        self.assertEqual(self.told["Runs"], (RUN_HEADER + user_force + LIVE_HEADER).split(","))
        self.succeed("make-path", "a.ply", "--touches", "1", "--out", "made.csv", "-q")
        self.assert_columns("Trajectories", "made.csv")

    def test_scenes_and_poses(self):
        self.assert_told("palpate info --json", "info", "a.ply")
        self.assert_told("palpate setup --json", "setup", "a.ply")
        query = ["query", "a.ply", "--pose", "0,0,0.02"]
        self.assert_told("palpate query --json", *query, may_lack=REACH)
        self.assert_told("palpate query --json", *query, "--pipeline", "paper")
        self.assert_told("palpate bench --json", "bench", "a.ply", "--trajectory", "path.csv", "--rounds", "1")

    def test_replay_and_how_it_was_made(self):
        args = ["replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv"]
        self.assert_told("palpate replay --json", *args, may_lack=REACH)
        self.assert_told("palpate replay --json", *args, "--pipeline", "paper")
        made = self.succeed(*args, "--json").json["made"]
        self.assertEqual(set(made), set(self.told["made"]) - {"device", "materials_checksum"})

    def test_live(self):
        self.write("hand.csv", path_csv([(0, 0, 0, 0.1), (1, 0, 0, 0.1)]))
        self.assert_told("palpate run --json", "run", "a.ply", "--trajectory", "hand.csv", "--hands", "left", "--no-gateway", "--seconds", "0.5")

    def test_evaluate(self):
        self.assert_told("palpate evaluate --json", "evaluate", *AMOUNTS, "--shapes", "sphere", "--models", "proxy", "--csv", "t.csv")
        self.assert_columns("palpate evaluate", "t.csv")
        self.succeed("make-scene", "sphere", "--spacing", "0.006", "--out", "ball.ply", "-q")
        self.assert_told("palpate evaluate --scene --json", "evaluate", "--scene", "ball.ply", "--tool", "0.01,0.01,0.01", "--pushes", "3",
                         "--slides", "1", "--rays", "7", "--models", "proxy", "--csv", "t2.csv")
        self.assert_columns("palpate evaluate --scene", "t2.csv")

    def test_trials(self):
        one = ["evaluate", "--trials", "3", "--trial-tools", "ball10", "--trial-places", "plate"]
        self.assert_told("palpate evaluate --trials --json", *one, "--csv", "t.csv")
        self.assert_columns("palpate evaluate --trials", "t.csv")
        self.assert_told("palpate evaluate --trials --stroke --json", *one, "--stroke", "1", "--csv", "ticks.csv")
        self.assert_columns("palpate evaluate --trials --stroke", "ticks.csv")

    def test_stability(self):
        self.assert_told("palpate stability --json", "stability", "--profiles", "omega", "--hands", "0.15,3,400", "--places", "1",
                         "--models", "field", "--delay", "0", "--csv", "t.csv")
        self.assert_columns("palpate stability", "t.csv")

    def test_reproduce(self):
        self.succeed("make-scene", "box", "--spacing", "0.006", "--out", "box.ply", "-q")
        self.assert_told("palpate reproduce --json", "reproduce", "box.ply", "--touches", "2", "--stall", "0", "--csv", "t.csv")
        self.assert_columns("palpate reproduce", "t.csv")

    def test_nothing_else_is_told(self):
        self.assertTrue(os.environ.get("PALPATE"))
        for heading, names in self.told.items():
            with self.subTest(heading=heading):
                self.assertGreater(len(names), 0)
                self.assertEqual(len(set(names)), len(names))


if __name__ == "__main__":
    unittest.main()
