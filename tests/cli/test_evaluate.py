"""palpate evaluate: figures that say what they say, and the same every time. How long a tick takes is not asserted."""

import csv
import io
import unittest

from support import Case

KEYS = ["shape", "spacing_m", "model", "direction_p50_deg", "direction_p95_deg", "direction_p99_deg", "magnitude_p05",
        "magnitude_p50", "magnitude_p95", "onset_p50_mm", "ripple_p50", "ripple_p95", "jump_max_n", "loop_p50", "loop_max",
        "silent", "flipped", "pushes", "through", "tick_p50_us", "tick_p99_us"]
SMALL = ["--spacings", "0.01", "--scenes", "1", "--places", "4"]


class Evaluate(Case):
    def rows(self, *args):
        return self.succeed("evaluate", *SMALL, "--json", "-q", *args).json

    def test_there_is_a_row_for_every_shape_spacing_and_model(self):
        rows = self.rows("--shapes", "sphere,plane", "--models", "proxy,density")
        self.assertEqual([(r["shape"], r["spacing_m"], r["model"]) for r in rows],
                         [(s, 0.01, m) for s in ("sphere", "plane") for m in ("proxy", "density")])
        for row in rows:
            self.assertEqual(list(row), KEYS)
            self.assertEqual(row["pushes"], 4)
            self.assertLessEqual(row["direction_p50_deg"], row["direction_p95_deg"])

    def test_the_paper_promises_no_stiffness(self):
        (row,) = self.rows("--shapes", "sphere", "--models", "density")
        self.assertIsNone(row["magnitude_p50"])
        self.assertIsNone(row["loop_max"])

    # Without noise there is nothing to smooth: a plane is a plane.
    def test_a_plane_without_noise_is_felt_as_one(self):
        (row,) = self.rows("--shapes", "plane", "--models", "proxy", "--noise", "0", "--tilt", "0")
        self.assertLess(row["direction_p99_deg"], 0.5)
        self.assertAlmostEqual(row["magnitude_p50"], 1.0, delta=0.02)
        self.assertLess(row["ripple_p95"], 0.01)
        self.assertEqual((row["silent"], row["flipped"], row["through"]), (0, 0, 0))

    def test_a_potential_does_no_work_around_a_loop(self):
        (row,) = self.rows("--shapes", "sphere", "--models", "field")
        self.assertLess(row["loop_max"], 1e-3)  # what the trapezoidal rule leaves at 0.1 mm

    def test_says_the_same_every_time(self):
        runs = [self.rows("--shapes", "torus", "--models", "proxy,field", "--seed", "7") for _ in range(2)]
        for rows in runs:
            for row in rows:
                del row["tick_p50_us"], row["tick_p99_us"]
        self.assertEqual(*runs)
        other = self.rows("--shapes", "torus", "--models", "proxy", "--seed", "8")
        self.assertNotEqual(other[0]["direction_p50_deg"], runs[0][0]["direction_p50_deg"])

    def test_the_file_has_what_is_printed(self):
        rows = self.rows("--shapes", "sphere", "--models", "proxy,density", "--csv", "table.csv")
        table = list(csv.DictReader(io.StringIO(self.read("table.csv").decode())))
        self.assertEqual(list(table[0]), KEYS)
        for line, row in zip(table, rows, strict=True):
            for key in KEYS[3:]:
                self.assertEqual(line[key], "" if row[key] is None else line[key])
                if row[key] is not None:
                    self.assertEqual(float(line[key]), row[key])

    def test_a_table_for_people(self):
        text = self.succeed("evaluate", *SMALL, "--shapes", "sphere", "--models", "proxy,density", "-q").out.decode()
        lines = text.splitlines()
        self.assertEqual(len(lines), 3)
        self.assertEqual({len(line) for line in lines}, {len(lines[0])})
        self.assertIn("-", lines[2].split())  # no stiffness promised

    def test_bad_usage(self):
        for arguments in (["--shapes", "cube"], ["--models", "magic"], ["--spacings", "0"], ["--places", "0"],
                          ["--scenes", "x"], ["--noise", "-1"], ["--detail", "0"]):
            self.refuse(2, arguments[0], "evaluate", *arguments)

    def test_a_tool_that_fits_nowhere(self):
        self.refuse(1, "torus", "evaluate", *SMALL, "--shapes", "torus", "--tool", "2,2,2", "-q")


if __name__ == "__main__":
    unittest.main()
