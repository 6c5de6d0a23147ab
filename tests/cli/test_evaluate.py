"""palpate evaluate: figures that say what they say, and the same every time. How long a tick takes is not asserted."""

import csv
import io
import math
import re
import tomllib
import unittest
import xml.etree.ElementTree as ElementTree
from html.parser import HTMLParser

from support import Case, head_of, table_of

KEYS = ["shape", "spacing_m", "model",
        "direction_p50_deg", "direction_p95_deg", "direction_p99_deg", "magnitude_p05", "magnitude_p50", "magnitude_p95",
        "onset_p50_mm", "silent", "flipped",
        "seen_p50_mm", "magnitude_seen_p05", "magnitude_seen_p50", "magnitude_seen_p95",
        "ripple_p50", "ripple_p95", "jump_max_n", "loop_p50", "loop_max", "pushes", "through", "fast", "fast_through",
        "friction_p05", "friction_p50", "friction_p95", "creep_max_um",
        "force_ratio_p05", "force_ratio_p50", "force_ratio_p95",
        "step_p05_mm", "step_p50_mm", "step_p95_mm", "step_over_p50_mm",
        "noisy_step_p05_mm", "noisy_step_p50_mm", "noisy_step_p95_mm",
        "edge_off_p50_mm", "edge_off_p95_mm", "edge_off_max_mm", "edge_where_mm",
        "tick_p50_us", "tick_p99_us", "tick_p99.9_us"]
FIGURES = ["direction", "force", "slide", "step", "edge", "friction", "densities"]
SERIES = [1, 2, 2, 3, 3, 3, 2]  # of the proxy on a step and a box, at two spacings; all but the first with the truth
NO_NOISE = ["--noise", "0", "--tilt", "0"]


def small(spacings="0.01", places=4, pushes=10, friction=0):
    """Little to do: ten seconds of rest with friction are ten thousand ticks."""
    return ["-q", "--scenes", "1", "--spacings", spacings, "--places", str(places), "--pushes", str(pushes),
            "--friction", str(friction)]


class Evaluate(Case):
    def rows(self, *args, **amounts):
        return self.succeed("evaluate", *small(**amounts), "--json", *args).json["rows"]


class Figures(Evaluate):
    def test_there_is_a_row_for_every_shape_spacing_and_model(self):
        rows = self.rows("--shapes", "sphere,plane", "--models", "proxy,density")
        self.assertEqual([(r["shape"], r["spacing_m"], r["model"]) for r in rows],
                         [(s, 0.01, m) for s in ("sphere", "plane") for m in ("proxy", "density")])
        for row in rows:
            self.assertEqual(list(row), KEYS + ["curves"])
            self.assertEqual((row["pushes"], row["fast"]), (10, 1))
            self.assertLessEqual(row["direction_p50_deg"], row["direction_p95_deg"])

    def test_every_shape_can_be_felt(self):
        rows = self.rows("--models", "field", places=1)
        self.assertEqual([r["shape"] for r in rows], ["sphere", "plane", "box", "cylinder", "torus", "step", "shell"])
        for row in rows:
            self.assertIsNotNone(row["direction_p50_deg"], row["shape"])

    def test_the_paper_promises_no_stiffness(self):
        (row,) = self.rows("--shapes", "sphere", "--models", "density")
        self.assertIsNone(row["magnitude_p50"])
        self.assertIsNone(row["loop_max"])

    # Without noise there is nothing to smooth: a plane is a plane.
    def test_a_plane_without_noise_is_felt_as_one(self):
        (row,) = self.rows("--shapes", "plane", "--models", "proxy", *NO_NOISE)
        self.assertLess(row["direction_p99_deg"], 0.5)
        self.assertAlmostEqual(row["magnitude_p50"], 1.0, delta=0.02)
        self.assertLess(row["ripple_p95"], 0.01)
        self.assertEqual((row["silent"], row["flipped"], row["through"]), (0, 0, 0))

    def test_a_potential_does_no_work_around_a_loop(self):
        (row,) = self.rows("--shapes", "sphere", "--models", "field")
        self.assertLess(row["loop_max"], 1e-3)  # what the trapezoidal rule leaves at 0.1 mm

    def test_pushes_are_counted_by_themselves(self):
        (row,) = self.rows("--shapes", "shell", "--models", "proxy", pushes=25)
        self.assertEqual((row["pushes"], row["through"], row["fast"], row["fast_through"]), (25, 0, 3, 0))
        (row,) = self.rows("--shapes", "sphere", "--models", "field", pushes=0)
        self.assertEqual((row["pushes"], row["through"]), (0, 0))

    def test_friction_is_what_is_set(self):
        for friction in (0.2, 0.5):
            (row,) = self.rows("--shapes", "plane", "--models", "proxy", *NO_NOISE, friction=friction)
            self.assertAlmostEqual(row["friction_p50"], friction, delta=0.05 * friction)
            self.assertLess(row["creep_max_um"], 1.0)
            for at, *measured in row["curves"]["friction"]:
                self.assertAlmostEqual(measured[1], at, delta=0.05 * at)

    def test_no_friction_where_there_is_none(self):
        for model, friction in (("proxy", 0), ("field", 0.3)):
            (row,) = self.rows("--shapes", "plane", "--models", model, friction=friction)
            self.assertIsNone(row["friction_p50"])
            self.assertIsNone(row["creep_max_um"])
            self.assertNotIn("friction", row["curves"])

    # Where the mean distance halves there are four times as many Gaussians, and the paper's model counts them.
    def test_densities_are_compared_with_the_first_spacing(self):
        coarse, _, fine, denser = self.rows("--shapes", "plane", "--models", "field,density", "--f-max", "1000", *NO_NOISE,
                                            spacings="0.01,0.005")
        self.assertIsNone(coarse["force_ratio_p50"])
        self.assertAlmostEqual(fine["force_ratio_p50"], 1.0, delta=0.15)
        self.assertGreater(denser["force_ratio_p50"], 2.0)

    def test_a_step_and_an_edge_are_crossed_where_there_is_one(self):
        # Without noise, so that nothing else is farther off than the turn about the edge, a quarter of a circle of 20 mm.
        step, box = self.rows("--shapes", "step,box", "--models", "proxy", "--noise", "0", "--tilt", "0", spacings="0.003")
        self.assertAlmostEqual(step["step_p50_mm"], 3.0, delta=0.6)
        self.assertIsNone(step["edge_off_max_mm"])
        self.assertGreater(box["edge_off_max_mm"], 0.0)
        self.assertLess(abs(box["edge_where_mm"]), 40.0)
        self.assertIsNone(box["step_p50_mm"])

    def test_says_the_same_every_time(self):
        runs = [self.rows("--shapes", "torus", "--models", "proxy,field", "--seed", "7") for _ in range(2)]
        for rows in runs:
            for row in rows:
                for key in [k for k in row if k.startswith("tick")]:
                    del row[key]
        self.assertEqual(*runs)
        other = self.rows("--shapes", "torus", "--models", "proxy", "--seed", "8")
        self.assertNotEqual(other[0]["direction_p50_deg"], runs[0][0]["direction_p50_deg"])

    def test_the_file_has_what_is_printed(self):
        rows = self.rows("--shapes", "sphere", "--models", "proxy,density", "--csv", "table.csv")
        table = list(csv.DictReader(io.StringIO(table_of(self.read("table.csv")))))
        head = tomllib.loads(head_of(self.read("table.csv")))
        self.assertEqual((head["made"]["command"], head["settings"]["shapes"], head["settings"]["seed"]), ("evaluate", "sphere", 1))
        self.assertNotIn("scene", head["made"])
        self.assertEqual(list(table[0]), KEYS)
        for line, row in zip(table, rows, strict=True):
            for key in KEYS[3:]:
                self.assertEqual(line[key] == "", row[key] is None, key)
                if row[key] is not None:
                    self.assertEqual(float(line[key]), row[key])

    def test_tables_for_people(self):
        text = self.succeed("evaluate", *small(friction=0.3), "--shapes", "sphere", "--models",
                            "proxy,density").out.decode()
        tables = [part.splitlines() for part in text.split("\n\n")][1::2]
        self.assertEqual([len(lines) for lines in tables], [3, 3, 3, 2, 3])  # pressed, seen, slid, friction of proxy, ticks
        for lines in tables:
            self.assertEqual({len(line) for line in lines}, {len(lines[0])})
            self.assertLessEqual(len(lines[0]), 100)
        self.assertIn("-", tables[0][2].split())  # no stiffness promised


class Attributes(HTMLParser):
    """All names of elements, and the values of attributes that a browser would fetch."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.fetched = [], []
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.fetched += [v for k, v in attributes if k in ("src", "href", "xlink:href", "data", "srcset")]


class Page(Evaluate):
    def page(self, *args):
        self.succeed("evaluate", *small(spacings="0.01,0.005", friction=0.3), "--html", "page.html", *args)
        return self.read("page.html").decode()

    def test_has_every_figure_and_asks_for_nothing(self):
        page = self.page("--shapes", "sphere", "--models", "density,proxy")
        parsed = Attributes(page)
        self.assertEqual(parsed.tags.count("svg"), len(FIGURES))
        self.assertEqual(parsed.fetched, [])
        self.assertNotIn("script", parsed.tags)
        self.assertEqual([a for a in re.findall(r"\w+://[^'\"\s<]+", page) if a != "http://www.w3.org/2000/svg"], [])
        self.assertIsNone(re.search(r"@import|url\((?!#)", page))
        self.assertNotRegex(page.lower().split("</style>")[1], r"\bnan\b")

    def test_is_well_formed(self):
        page = self.page("--shapes", "plane,box", "--models", "proxy,density")
        body = ElementTree.fromstring(page[page.index("<body>"):page.index("</html>")])
        self.assertEqual(len(body.findall(".//{http://www.w3.org/2000/svg}svg")), len(FIGURES))
        self.assertEqual(len(body.find(".//table").findall("tr")), 1 + 2 * 2 * 2)

    def test_figures_as_files_are_those_of_the_page(self):
        self.page("--shapes", "step,box", "--models", "proxy", "--svg", ".")
        self.assertEqual(self.files(), sorted(["page.html"] + [f"evaluate-{name}.svg" for name in FIGURES]))
        page = self.read("page.html").decode()
        for name, series in zip(FIGURES, SERIES, strict=True):
            svg = self.read(f"evaluate-{name}.svg").decode()
            root = ElementTree.fromstring(svg)
            self.assertEqual(root.tag, "{http://www.w3.org/2000/svg}svg")
            lines = root.findall(".//{http://www.w3.org/2000/svg}g[@clip-path]/{http://www.w3.org/2000/svg}g")
            self.assertEqual(len(lines), series, name)
            self.assertIn(re.sub(r"<style>.*?</style>\n", "", svg, flags=re.S).strip(), page)

    # What is drawn is what was measured: the line of the true force goes from corner to corner of its values.
    def test_a_line_goes_where_its_values_are(self):
        (row,) = self.rows("--shapes", "plane", "--models", "proxy", "--svg", ".", *NO_NOISE)
        values = [(1e3 * at, p50) for at, _, p50, _ in row["curves"]["force_n"]]
        svg = ElementTree.fromstring(self.read("evaluate-force.svg"))
        group = svg.find(".//{http://www.w3.org/2000/svg}g[@clip-path]/{http://www.w3.org/2000/svg}g")
        path = group.find("{http://www.w3.org/2000/svg}path[@class='line']").get("d")
        points = [tuple(map(float, p.split())) for p in re.split("[ML]", path)[1:]]
        self.assertEqual(len(points), len(values))
        for axis in (0, 1):
            a, b = values[0][axis], values[-1][axis]
            p, q = points[0][axis], points[-1][axis]
            for value, point in zip(values, points):
                self.assertAlmostEqual(point[axis], p + (q - p) * (value[axis] - a) / (b - a), delta=0.3)
        self.assertLess(points[0][0], points[-1][0])
        self.assertGreater(points[0][1], points[-1][1])  # up is up


class Captures(Evaluate):
    KEYS = ["model", "pushes", "onset_within_5mm_percent", "late_percent", "early_percent", "onset_p50_mm",
            "silent_5mm_percent", "silent_10mm_percent", "avoidable_5mm_percent", "untouched_percent",
            "push_step_p50_n", "push_step_max_n",
            "slides", "slide_strong_percent", "slide_silent_percent", "slide_silent_touched_percent",
            "slide_step_p50_n", "slide_step_max_n",
            "tick_p50_us", "tick_p99.9_us", "first_touch_within_5mm_percent",
            "against_p10", "against_p90", "silent_in_one_percent"]
    ARGS = ["evaluate", "-q", "--scene", "ball.ply", "--tool", "0.01,0.01,0.01", "--pushes", "6", "--slides", "2",
            "--rays", "30"]

    def setUp(self):
        super().setUp()
        self.succeed("make-scene", "sphere", "--spacing", "0.004", "--out", "ball.ply", "-q")

    def test_a_clean_ball_is_felt_where_it_is_seen(self):
        (row,) = self.succeed(*self.ARGS, "--models", "proxy", "--json").json["rows"]
        self.assertEqual(list(row), self.KEYS)
        self.assertEqual((row["pushes"], row["slides"]), (6, 2))
        self.assertEqual((row["onset_within_5mm_percent"], row["late_percent"], row["early_percent"]), (100, 0, 0))
        self.assertEqual((row["untouched_percent"], row["silent_5mm_percent"], row["slide_strong_percent"]), (0, 0, 0))
        self.assertIsNone(row["against_p10"])

    def test_the_same_capture_feels_the_same(self):
        (row,) = self.succeed(*self.ARGS, "--models", "proxy", "--against", "ball.ply", "--json").json["rows"]
        self.assertEqual((row["against_p10"], row["against_p90"], row["silent_in_one_percent"]), (1, 1, 0))

    def test_the_worst_pushes_are_drawn_and_can_be_replayed(self):
        out = self.succeed(*self.ARGS, "--models", "proxy,field", "--worst", ".", "--html", "p.html", "--csv", "t.csv")
        pushes = [f for f in self.files() if f.startswith("push-")]
        self.assertEqual(len(pushes), 2 * 5)
        for name in pushes:
            self.assertIn(name, out.out.decode())
        page = self.read("p.html").decode()
        self.assertEqual(page.count("<svg"), 2 * 2 * 5)
        self.assertIn("ball.ply", page)
        table = csv.DictReader(io.StringIO(table_of(self.read("t.csv"))))
        self.assertEqual([row["model"] for row in table], ["proxy", "field"])
        name = next(f for f in pushes if "proxy" in f)
        run = self.succeed("replay", "ball.ply", "--trajectory", name, "--tool", "0.01,0.01,0.01", "--out", "run.csv",
                           "--json").json
        self.assertGreater(run["force_max"], 5.0)  # three radii deep: 15 N

    def test_what_makes_no_sense_is_refused(self):
        self.refuse(1, "none.ply", "evaluate", "-q", "--scene", "none.ply")
        self.refuse(1, "--worst", *self.ARGS, "--worst", "nowhere")
        self.refuse(1, "--stiffness", *self.ARGS, "--stiffness", "0")
        self.refuse(1, "--html", *self.ARGS, "--html", "ball.ply")


class Trials(Evaluate):
    AMOUNTS = ["evaluate", "-q", "--trials", "6"]

    def trials(self, *args):
        told = self.succeed(*self.AMOUNTS, "--json", *args).json
        return told.get("rows", told)

    def test_there_is_a_row_for_every_tool_place_and_kind_of_capture(self):
        self.write("two.toml", '[[ellipsoid]]\nname = "a"\nsemi_axes = [0.01, 0.01, 0.01]\n'
                   '[[ellipsoid]]\nname = "b"\nsemi_axes = [0.01, 0.01, 0.02]\nposition = [0.0, 0.0, 0.01]\n')
        rows = self.trials("--trial-tools", "ball20,two.toml", "--trial-places", "face,sheet", "--like", "even,holes")
        self.assertEqual([(r["tool"], r["place"], r["like"]) for r in rows],
                         [(t, p, k) for t in ("ball20", "two") for p in ("face", "sheet") for k in ("even", "holes")])
        for row in rows:
            self.assertEqual((row["strokes"], row["through"]), (6, 0))
            self.assertEqual(row["silent"], len(row["silent_strokes"]))

    def test_a_ball_on_a_face_is_felt_where_it_is_seen(self):
        (row,) = self.trials("--trial-tools", "ball5", "--trial-places", "face")
        self.assertEqual((row["silent"], row["sunk"], row["stuck"], row["first_silent"]), (0, 0, 0, None))
        self.assertGreater(row["onsets"], 0)
        self.assertEqual(row["within_1mm_percent"], 100.0)
        self.assertAlmostEqual(row["magnitude_p50"], 1.0, delta=0.05)

    def test_says_the_same_every_time_and_in_csv(self):
        arguments = ["--trial-tools", "ball10,disc", "--trial-places", "edge", "--csv", "t.csv"]
        rows, again = self.trials(*arguments), self.trials(*arguments)
        (header, *lines) = list(csv.reader(io.StringIO(table_of(self.read("t.csv")))))
        self.assertEqual(len(lines), 2)
        for row, other, line in zip(rows, again, lines):
            for key in [k for k in row if not k.startswith("tick")]:
                self.assertEqual(row[key], other[key], key)
            of_csv = dict(zip(header, line))
            self.assertAlmostEqual(float(of_csv["onset_p50_mm"]), row["onset_p50_mm"])

    def test_a_stroke_can_be_repeated_alone(self):
        one = ["--trial-tools", "ball10", "--trial-places", "plate"]
        for stroke in range(3):
            told = self.trials(*one, "--stroke", str(stroke), "--csv", "ticks.csv")
            self.assertEqual(told["stroke"], stroke)
            ticks = list(csv.DictReader(io.StringIO(table_of(self.read("ticks.csv")))))
            speed = math.dist(*[[float(t[k]) for k in "xyz"] for t in ticks[:2]]) / 1e-3
            self.assertAlmostEqual(speed / told["speed"], 1.0, delta=0.01)
            self.assertGreater(max(float(t["fz"]) for t in ticks), 1.0)

    def test_a_table_for_people(self):
        text = self.succeed(*self.AMOUNTS, "--trial-tools", "ball20", "--trial-places", "corner").out.decode()
        self.assertRegex(text, r"(?m)^ball20 +corner +even +6 ")

    def test_what_makes_no_sense_is_refused(self):
        self.refuse(1, "spoon", *self.AMOUNTS, "--trial-tools", "spoon")
        self.write("two.toml", '[[ellipsoid]]\nname = "a"\nsemi_axes = [0.01, 0.01, 0.01]\n')
        self.refuse(1, "is also an input", *self.AMOUNTS, "--trial-tools", "two.toml", "--csv", "two.toml")
        self.refuse(2, "--trial-places", *self.AMOUNTS, "--trial-places", "moon")
        self.refuse(2, "--like", *self.AMOUNTS, "--like", "dust")
        self.refuse(1, "--stroke", *self.AMOUNTS, "--stroke", "0")
        self.refuse(1, "--stiffness", *self.AMOUNTS, "--stiffness", "0")


class BadInput(Evaluate):
    def test_bad_usage(self):
        for arguments in (["--shapes", "cube"], ["--models", "magic"], ["--spacings", "0"], ["--places", "0"],
                          ["--scenes", "x"], ["--noise", "-1"], ["--detail", "0"], ["--pushes", "-1"],
                          ["--pushes", "1e9"], ["--friction", "-0.1"], ["--tool", "0.02,0.02"]):
            self.refuse(2, arguments[0], "evaluate", *arguments)

    def test_what_would_do_nothing_is_refused(self):
        for option, value in (("--against", "a.ply"), ("--worst", "."), ("--rays", "7"), ("--slides", "3"),
                              ("--opacity-min", "0.2"), ("--frame", "y-up"), ("--crop-sphere", "0,0,0,1")):
            self.refuse(2, [option, "requires --scene"], "evaluate", option, value)
        self.refuse(2, ["--mirror", "requires --scene"], "evaluate", "--mirror")
        for option, value in (("--trial-tools", "ball5"), ("--trial-places", "face"), ("--like", "holes"), ("--stroke", "0")):
            self.refuse(2, [option, "requires --trials"], "evaluate", option, value)
        trials = ("evaluate", "--trials", "3")
        self.refuse(2, ["--scene", "excludes --trials"], *trials, "--scene", "a.ply")
        for option, value in (("--html", "p.html"), ("--svg", "."), ("--models", "proxy"), ("--shapes", "box"), ("--tool", "1,1,1"),
                              ("--spacings", "0.01"), ("--noise", "0"), ("--places", "1"), ("--pushes", "1"), ("--f-max", "3")):
            self.refuse(2, [option, "excludes --trials"], *trials, option, value)
        for option, value in (("--shapes", "box"), ("--tilt", "3"), ("--scenes", "3"), ("--places", "1")):
            self.refuse(2, [option, "excludes --scene"], "evaluate", "--scene", "a.ply", option, value)

    def test_a_file_of_settings_may_have_those_of_other_commands(self):
        self.write("c.toml", 'opacity-min = 0.2\nrays = 7\nlike = "holes"\n')
        box = ("--shapes", "box", "--models", "field", "--config", "c.toml")
        self.assertEqual(self.rows(*box, places=1, pushes=0)[0]["shape"], "box")
        self.write("c.toml", 'scene = "none.ply"\nopacity-min = 0.2\ntool = [0.02, 0.02, 0.02]\n')
        self.assertEqual(self.rows(*box, places=1, pushes=0)[0]["shape"], "box")
        self.succeed("evaluate", "-q", "--trials", "1", "--trial-tools", "ball10", "--trial-places", "face", "--config", "c.toml")
        self.refuse(1, "none.ply", "evaluate", "-q", "--config", "c.toml")

    def test_a_tool_that_fits_nowhere(self):
        self.refuse(1, "torus", "evaluate", *small(), "--shapes", "torus", "--tool", "2,2,2")

    def test_a_sheet_too_small_to_push_into(self):
        self.refuse(1, ["shell", "pushed"], "evaluate", *small(), "--shapes", "shell", "--tool",
                    "0.06,0.06,0.06")

    def test_files_that_cannot_be_written_are_refused_before_the_work(self):
        for option in ("--csv", "--html"):
            self.refuse(1, "nowhere", "evaluate", "-q", option, "nowhere/file")
        self.refuse(1, "--svg", "evaluate", "-q", "--svg", "nowhere")
        self.write("same", "")
        self.refuse(1, "--html", "evaluate", "-q", "--csv", "same", "--html", "same")
        self.write("settings.toml", "places = 1\n")
        self.refuse(1, "settings.toml", "evaluate", "-q", "--config", "settings.toml", "--html", "settings.toml")


if __name__ == "__main__":
    unittest.main()
