"""Every command as a black box: help, exit codes, what goes where, and the query document."""

import math
import re
import unittest

from support import COMMANDS, RUN_HEADER, Case, columns_of, path_csv, ply, random_rows, splat, table_of, tapping_path, wall_rows

QUERY_KEYS = ["candidates", "filtered", "contacts", "force", "torque", "confidence"]
CONTACT_KEYS = ["id", "k_min", "lambda", "opacity", "center", "point", "normal", "depth", "part", "confidence"]


class Help(Case):
    def test_every_command_explains_itself(self):
        main = self.succeed("--help").out.decode()
        for command in COMMANDS:
            self.assertIn(f"\n  {command} ", main)
            for flag in ("--help", "-h"):
                text = self.succeed(command, flag).out.decode()
                self.assertIn("Usage: palpate " + command, text)
                self.assertIn("--help", text)
        self.assertEqual(self.succeed("--help").err, b"")

    def test_help_lists_the_options_of_the_contract(self):
        scene = ["--opacity-min", "--sigma", "--iso", "--scale", "--rotate", "--translate", "--frame", "--config"]
        for command, more in {
            "info": ["--json"],
            "query": ["--pose", "--tool", "--model", "--json"],
            "replay": ["--trajectory", "--out", "--tool", "--model", "--json", "--quiet"],
            "report": ["--out"],
        }.items():
            text = self.succeed(command, "--help").out.decode()
            for option in scene + more:
                self.assertIn(option + " ", text.replace(",", " "), (command, option))

    def test_help_shows_units_and_defaults(self):
        text = self.succeed("query", "--help").out.decode()
        self.assertIn("0.02,0.02,0.04", text)
        self.assertRegex(text, r"=0\.1 |\[0\.1\] ")  # CLI11 2.3 and 2.4

    def test_help_has_a_title_for_every_group(self):
        titles = {"Positionals", "Options", "Scene", "Tool", "Force", "Device", "Loop", "Gateway", "Room"}
        for command in COMMANDS + ["reproduce"]:
            text = self.succeed(command, "--help").out.decode()
            self.assertLessEqual(set(re.findall(r"^(\S.*):$", text, re.MULTILINE)), titles, command)

    def test_help_speaks_only_of_options_that_the_command_has(self):
        for command in COMMANDS + ["reproduce"]:
            text = self.succeed(command, "--help").out.decode()
            self.assertEqual("--pipeline paper" in text, bool(re.search(r"^  --pipeline ", text, re.MULTILINE)), command)

    def test_version_is_one_line(self):
        out = self.succeed("--version").out.decode()
        self.assertRegex(out, r"\Apalpate \d+\.\d+\.\d+\n\Z")


class Usage(Case):
    def setUp(self):
        super().setUp()
        self.write("a.ply", ply([splat()]))

    def test_no_arguments_show_the_help_as_bad_usage(self):
        result = self.run_palpate()
        self.assertEqual(result.code, 2)
        self.assertEqual(result.out, b"")
        self.assertIn(b"Usage", result.err)

    def test_bad_usage_is_two_and_names_the_culprit(self):
        self.refuse(2, "frobnicate", "frobnicate")
        self.refuse(2, "SCENE", "info")
        self.refuse(2, "--pose", "query", "a.ply")
        self.refuse(2, "--frobnicate", "info", "a.ply", "--frobnicate")
        self.refuse(2, "surplus", "info", "a.ply", "surplus")
        self.refuse(2, "--sigma", "info", "a.ply", "--sigma")
        self.refuse(2, "--trajectory", "replay", "a.ply", "--out", "r.csv")
        self.refuse(2, "--out", "make-scene", "sphere")
        self.refuse(2, "dodecahedron", "make-scene", "dodecahedron", "--out", "s.ply")
        self.refuse(2, "tcsh", "completion", "tcsh")

    def test_what_from_replaces_is_not_called_required(self):
        help_text = self.succeed("replay", "--help").out.decode()
        (line,) = [line for line in help_text.splitlines() if line.strip().startswith("--trajectory")]
        self.assertNotIn("REQUIRED", line)
        self.refuse(2, "--trajectory or --from", "replay", "a.ply", "--out", "r.csv")
        self.refuse(2, "SCENE or --from", "replay", "--trajectory", "p.csv", "--out", "r.csv")

    def test_what_is_not_expected_is_told_in_order_and_before_what_is_missing(self):
        extra = ("info", "a.ply", "one", "two", "three")
        self.refuse(2, "not expected: one two three", *extra)
        self.refuse(2, ["--profile;", "did you mean --profiles?"], "stability", "--profile", "omega")
        self.refuse(2, ["--opacity_min;", "did you mean --opacity-min?"], "info", "a.ply", "--opacity_min", "0.2")
        self.refuse(2, ["--trajectry;", "did you mean --trajectory?"], "replay", "a.ply", "--trajectry", "p.csv", "--out", "r.csv")
        self.assertNotIn(b"did you mean", self.refuse(2, "--frobnicate", "info", "a.ply", "--frobnicate").err)

    def test_a_list_ends_with_its_argument(self):
        self.succeed("make-scene", "--like", "tails", "plane", "--out", "x.ply", "--spacing", "0.02", "-q")
        self.succeed("make-scene", "--like", "tails,holes", "plane", "--out", "y.ply", "--spacing", "0.02", "-q")
        self.succeed("make-scene", "--like", "tails", "--like", "holes", "plane", "--out", "z.ply", "--spacing", "0.02", "-q")
        body = [self.read(name).split(b"end_header\n")[1] for name in ("x.ply", "y.ply", "z.ply")]
        self.assertNotEqual(body[0], body[1])
        self.assertEqual(body[1], body[2])
        self.refuse(1, "missing.ply", "stability", "--profiles", "omega", "missing.ply")
        self.refuse(1, "missing.ply", "run", "--hands", "left", "missing.ply", "--seconds", "0.1")
        self.refuse(1, "missing.ply", "run", "--scenes", ".", "missing.ply", "--seconds", "0.1")
        self.refuse(2, ["not expected", "field"], "stability", "--models", "proxy", "a.ply", "field")

    def test_a_device_that_is_none_names_all_forms(self):
        self.refuse(2, ["--device", "omega", "simulated", "giant-mujoco", "plugin:PATH.so", "ros1:/NAME", "ros2:/NAME"],
                    "run", "--device", "omega")

    def test_an_error_is_one(self):
        self.refuse(1, "missing.ply", "info", "missing.ply")

    def test_options_may_stand_anywhere_and_take_an_equals_sign(self):
        a = self.succeed("query", "a.ply", "--pose", "0.01,0,0", "--sigma", "2", "--json").figures
        b = self.succeed("query", "--json", "--sigma=2", "--pose=0.01,0,0", "a.ply").figures
        self.assertEqual(a, b)

    def test_vectors_may_begin_with_a_minus(self):
        def center(*args):
            return self.succeed("query", "a.ply", "--pose", *args, "--json").json["contacts"][0]["center"]

        self.assertEqual(center("-1,0,0", "--translate", "-1,0,0"), [-1, 0, 0])
        self.assertEqual(center("-1,-.5,-1e-2", "--translate=-1,-.5,-0.01"), [-1, -0.5, -0.01])
        self.assertEqual(center("0,0,0,-1,0,0,0", "--rotate", "-1,0,0,0"), [0, 0, 0])
        self.assertEqual(center("0,0,0", "--crop-box", "-1,-1,-1,1,1,1"), [0, 0, 0])
        self.assertEqual(center("0,0,0", "--crop-sphere", "-0.5,0,0,1"), [0, 0, 0])

    def test_numbers_may_have_spaces_and_a_plus(self):
        a = self.succeed("query", "a.ply", "--pose", "0.01,0,0", "--json").figures
        self.assertEqual(a, self.succeed("query", "a.ply", "--pose", " +0.01, 0, +0 ", "--json").figures)


class Query(Case):
    def setUp(self):
        super().setUp()
        self.write("a.ply", ply(random_rows(300, 1, spread=0.07)))

    def query(self, *args):
        return self.succeed("query", "a.ply", "--json", *args).figures

    def assert_vector(self, v):
        self.assertEqual(len(v), 3)
        for x in v:
            self.assertIsInstance(x, float)
            self.assertTrue(math.isfinite(x))

    def test_the_document_is_that_of_the_contract(self):
        document = self.query("--pose", "0.01,0.02,0.03")
        self.assertEqual(list(document), QUERY_KEYS)
        self.assertIsInstance(document["candidates"], int)
        self.assertIsInstance(document["filtered"], int)
        self.assert_vector(document["force"])
        self.assert_vector(document["torque"])
        contacts = document["contacts"]
        self.assertGreater(len(contacts), 10)
        self.assertGreaterEqual(document["filtered"], len(contacts))
        self.assertGreaterEqual(document["candidates"], document["filtered"])
        ids = [c["id"] for c in contacts]
        self.assertEqual(ids, sorted(set(ids)))
        for c in contacts:
            self.assertEqual(list(c), CONTACT_KEYS)
            self.assertIsInstance(c["id"], int)
            self.assertTrue(0 < c["k_min"] <= 1)
            self.assertTrue(0 <= c["lambda"] <= 1)
            self.assertTrue(0.1 < c["opacity"] <= 1)
            self.assertGreater(c["depth"], 0)
            self.assertEqual(c["part"], "tool")
            self.assertTrue(0 <= c["confidence"] <= 1)
            self.assertAlmostEqual(math.hypot(*c["normal"]), 1, delta=1e-12)
            for key in ("center", "point", "normal"):
                self.assert_vector(c[key])

    def test_far_away_there_is_nothing_and_no_force(self):
        self.assertEqual(self.query("--pose", "100,0,0"), {
            "candidates": 0, "filtered": 0, "contacts": [], "force": [0, 0, 0], "torque": [0, 0, 0],
            "confidence": 1})

    def test_the_force_is_that_of_a_tool_that_rests(self):
        """As in captures, a proxy that starts here in contact has no force in its first step."""
        self.succeed("make-scene", "plane", "--spacing", "0.006", "--noise", "0.0015", "--tilt", "10", "--out", "noisy.ply", "-q")
        self.write("held.csv", path_csv([(k / 1000, 0.03, 0.02, 0.02) for k in range(300)]))
        for model in ("proxy", "field", "density"):
            self.succeed("replay", "noisy.ply", "--trajectory", "held.csv", "--model", model, "--out", "run.csv", "-q")
            run = columns_of(self.read("run.csv"))
            self.assertEqual(float(run["fz"][0]) == 0, model == "proxy")
            document = self.succeed("query", "noisy.ply", "--pose", "0.03,0.02,0.02", "--model", model, "--json").json
            self.assertGreater(document["force"][2], 0.1, model)
            for felt, columns in ((document["force"], "fx fy fz"), (document["torque"], "tx ty tz")):
                for value, column in zip(felt, columns.split()):
                    self.assertAlmostEqual(value, float(run[column][-1]), delta=1e-7, msg=(model, column))

    def test_an_orientation_turns_the_tool(self):
        upright = self.query("--pose", "0.2,0,0", "--tool", "0.001,0.001,0.2")
        lying = self.query("--pose", "0.2,0,0,1,0,1,0", "--tool", "0.001,0.001,0.2")  # normalised
        self.assertLess(len(upright["contacts"]), len(lying["contacts"]))

    def test_huge_poses_are_far_away(self):
        self.assertEqual(self.query("--pose", "1e12,-1e12,0")["contacts"], [])
        for pose in ("1.1e12,0,0", "1e300,-1e300,0", "1.7e308,1.7e308,1.7e308"):
            self.refuse(2, "--pose", "query", "a.ply", "--pose", pose)

    def test_the_papers_pipeline_says_what_it_can_miss(self):
        exact = self.query("--pose", "0.01,0.02,0.03")
        paper = self.query("--pose", "0.01,0.02,0.03", "--pipeline", "paper", "--search-radius", "0.12")
        self.assertEqual(list(paper), QUERY_KEYS + ["search_radius", "can_miss"])
        self.assertEqual(paper["search_radius"], 0.12)
        self.assertEqual(paper["can_miss"], 0)  # the longest sigma is e^-3.2 = 0.041 m, the tool 0.04 m
        self.assertEqual([c["id"] for c in paper["contacts"]], [c["id"] for c in exact["contacts"]])
        short = self.query("--pose", "0.01,0.02,0.03", "--pipeline", "paper", "--search-radius", "0.03")
        self.assertGreater(short["can_miss"], 0)
        self.assertLess(len(short["contacts"]), len(exact["contacts"]))
        default = self.query("--pose", "0,0,0", "--pipeline", "paper")
        self.assertGreater(default["search_radius"], 0.04)

    def test_says_how_it_was_made(self):
        made = self.succeed("query", "a.ply", "--json", "--pose", "0.01,0.02,0.03", "--sigma", "1.5").json["made"]
        self.assertEqual((made["command"], made["scene"]), ("query", "a.ply"))
        self.assertRegex(made["scene_checksum"], "^xxh3-16MiB:[0-9a-f]{16}$")
        settings = made["settings"]
        self.assertEqual([settings[name] for name in ("pose", "sigma", "model")], ["0.01,0.02,0.03", 1.5, "proxy"])
        paper = self.succeed("query", "a.ply", "--json", "--pose", "0,0,0", "--pipeline", "paper").json
        settings = paper["made"]["settings"]
        self.assertEqual((settings["model"], settings["search-radius"]), ("density", paper["search_radius"]))

    def test_text_says_the_same(self):
        document = self.query("--pose", "0.01,0.02,0.03")
        result = self.succeed("query", "a.ply", "--pose", "0.01,0.02,0.03")
        self.assertIn(f"{len(document['contacts'])} in contact", result.out.decode())
        self.assertIn("captured axes are taken as world axes", result.err.decode())

    def test_nothing_left_to_touch_is_a_warning(self):
        for pipeline in ("exact", "paper"):
            result = self.succeed("query", "a.ply", "--pose", "0,0,0", "--opacity-min", "1", "--json",
                                  "--pipeline", pipeline)
            self.assertEqual(result.json["contacts"], [])
            self.assertIn(b"300 below --opacity-min", result.err)


class Info(Case):
    def test_figures_by_hand(self):
        nan = math.nan
        rows = [splat(0, 0, 0), splat(1, 2, 3, opacity=-3), splat(nan, 0, 0), splat(0, 0, 1, rot=(0, 0, 0, 0)),
                splat(0, 1, 0, scale=(-4, -4, -math.inf)), splat(1e30, 0, 0)]
        self.write("a.ply", ply(rows) + b"trail")
        document = self.succeed("info", "a.ply", "--json").json
        self.assertEqual(document["gaussians"], 6)
        self.assertEqual(document["trailing_bytes"], 5)
        self.assertEqual(document["sh_degree"], 0)
        self.assertEqual(document["bounds"], {"min": [0, 0, 0], "max": [1, 2, 3]})
        self.assertEqual(document["lint"], {"nan": 1, "infinite": 1, "zero_quaternion": 1, "zero_scale": 0,
                                            "giant": 0, "flat": 1})
        kept = document["filter"]
        self.assertEqual((kept["kept"], kept["defective"], kept["low_opacity"]), (2, 3, 1))
        self.assertAlmostEqual(kept["share"], 2 / 6)
        self.assertAlmostEqual(document["opacity"]["1"], 1 / (1 + math.exp(-2)), delta=1e-12)
        text = self.succeed("info", "a.ply").out.decode()
        self.assertIn("6 Gaussians, 5 bytes after the data", text)
        self.assertIn("2 of 6", text)

    def test_options_change_what_is_kept(self):
        self.write("a.ply", ply(random_rows(500, 4)))

        def kept(*args):
            return self.succeed("info", "a.ply", "--json", *args).json["filter"]

        self.assertGreater(kept()["kept"], kept("--opacity-min", "0.5")["kept"])
        self.assertEqual(kept("--opacity-min", "0.05", "--iso", "0.3")["kept"], kept("--opacity-min", "0.3")["kept"])
        self.assertGreater(kept("--max-scale", "0.01")["over_max_scale"], 0)
        self.assertGreater(kept("--crop-sphere", "0,0,0,0.1")["outside_crop"], 0)

    def test_the_limit_that_drops_giants_is_in_metres(self):
        for seed in range(5):
            rows = random_rows(300, seed) + [splat(0.01 * k, 0, 0, scale=(-2.0, -6, -6)) for k in range(7)]
            self.write("a.ply", ply(rows))
            for scale in ("1", "0.0123", "170"):
                options = ("a.ply", "--scale", scale, "--opacity-min", "0")
                giants = self.succeed("info", *options, "--json").json["lint"]["giant"]
                self.assertGreaterEqual(giants, 7)
                text = self.succeed("info", *options).out.decode()
                said = re.search(r"(\d+) giant \(longest sigma above (\S+) m, .*: drop them with --max-scale ([^\s,]+),", text)
                self.assertEqual((int(said[1]), said[2]), (giants, said[3]))
                dropped = self.succeed("info", *options, "--max-scale", said[3], "--json").json["filter"]["over_max_scale"]
                # Rounded down: a Gaussian just below the limit may go, too.
                self.assertIn(dropped - giants, (0, 1, 2), (seed, scale))

    def test_frames_turn_the_named_axis_up(self):
        self.write("a.ply", ply([splat(1, 2, 3)]))
        for frame, up in {"as-is": 3, "z-up": 3, "z-down": -3, "y-up": 2, "y-down": -2, "x-up": 1, "x-down": -1}.items():
            box = self.succeed("info", "a.ply", "--json", "--frame", frame).json["world_bounds"]
            center = [(a + b) / 2 for a, b in zip(box["min"], box["max"])]
            self.assertAlmostEqual(center[2], up, delta=1e-9, msg=frame)
            self.assertAlmostEqual(math.hypot(*center), math.sqrt(14), delta=1e-9, msg=frame)

    def test_one_bad_double_does_not_spoil_the_others(self):
        for stray in (1e7, 1e30):
            self.write("a.ply", ply([splat(stray, 0, 0), splat(0.1, 0, 0), splat(0.2, 0, 0)], kind="double"))
            for x in ("0.1", "0.2"):
                contacts = self.succeed("query", "a.ply", "--pose", x + ",0,0", "--tool", "0.001,0.001,0.001",
                                        "--json").json["contacts"]
                self.assertEqual(len(contacts), 1, stray)
                self.assertAlmostEqual(contacts[0]["center"][0], float(x), delta=1e-7)


class Replay(Case):
    def setUp(self):
        super().setUp()
        self.write("wall.ply", ply(wall_rows()))

    def replay(self, trajectory, *args):
        self.write("path.csv", trajectory)
        result = self.succeed("replay", "wall.ply", "--trajectory", "path.csv", "--out", "run.csv", *args)
        return result, self.read("run.csv")

    def test_the_run_has_the_header_of_the_contract(self):
        _, run = self.replay(tapping_path())
        self.assertEqual(table_of(run).split("\n")[0], RUN_HEADER)
        columns = columns_of(run)
        self.assertEqual(len(columns["t"]), 400)
        for name in ("candidates", "filtered", "colliding"):
            self.assertTrue(all(value.isdigit() for value in columns[name]), name)
        colliding = [int(n) for n in columns["colliding"]]
        self.assertGreater(max(colliding), 5)
        self.assertEqual(colliding[0], 0)
        for k, n in enumerate(colliding):
            self.assertEqual(n > 0, float(columns["k_max"][k]) > 0)
            if n == 0:
                self.assertEqual([float(columns[f][k]) for f in ("fx", "fy", "fz")], [0, 0, 0])
            self.assertGreaterEqual(float(columns["fz"][k]), 0)  # out of the wall, never into it

    def test_poses_come_back_digit_for_digit(self):
        poses = [(0.1 * k, 1 / (k + 3), -2 / 7, 1e-17 * k, 1, 0, 0, 0) for k in range(20)]
        _, run = self.replay(path_csv(poses, "t,x,y,z,qw,qx,qy,qz"))
        columns = columns_of(run)
        for k, pose in enumerate(poses):
            for name, value in zip("t x y z qw qx qy qz px py pz".split(), (*pose, *pose[1:4])):
                self.assertEqual(float(columns[name][k]), value)

    def test_agrees_with_query_on_the_first_pose(self):
        _, run = self.replay(path_csv([(0, 0.01, 0, 0.03)]))
        columns = columns_of(run)
        document = self.succeed("query", "wall.ply", "--pose", "0.01,0,0.03", "--json").json
        self.assertEqual(int(columns["colliding"][0]), len(document["contacts"]))
        self.assertEqual(int(columns["candidates"][0]), document["candidates"])
        for name, value in zip(("fx", "fy", "fz"), document["force"]):  # of a plain wall it settles at once
            self.assertAlmostEqual(float(columns[name][0]), value, delta=1e-9)
        self.assertEqual(float(columns["k_max"][0]), max(c["k_min"] for c in document["contacts"]))

    def test_a_user_force_is_carried_over(self):
        _, run = self.replay(path_csv([(0, 0, 0, 1, 1, 2, 3), (1, 0, 0, 1, -1, 0.1, 0)], "t,x,y,z,ufx,ufy,ufz"))
        self.assertEqual(table_of(run).split("\n")[0], RUN_HEADER + ",ufx,ufy,ufz")
        columns = columns_of(run)
        self.assertEqual([float(v) for v in columns["ufy"]], [2, 0.1])

    def test_the_summary_agrees_with_the_run(self):
        result, run = self.replay(tapping_path(), "--json")
        columns = columns_of(run)
        summary = result.json
        colliding = [int(n) for n in columns["colliding"]]
        self.assertEqual(summary["poses"], 400)
        self.assertEqual(summary["contact_poses"], sum(n > 0 for n in colliding))
        self.assertEqual(summary["colliding_max"], max(colliding))
        self.assertEqual(summary["episodes"], 2)
        self.assertAlmostEqual(summary["seconds"], 0.399, delta=1e-12)
        force = max(math.hypot(*(float(columns[f][k]) for f in ("fx", "fy", "fz"))) for k in range(400))
        self.assertAlmostEqual(summary["force_max"], force, delta=1e-12)
        compute = sorted(float(v) for v in columns["compute_us"])
        self.assertEqual(summary["compute_us"]["max"], compute[-1])
        self.assertTrue(compute[0] <= summary["compute_us"]["p50"] <= summary["compute_us"]["p99"])

    def test_no_number_is_ever_nan(self):
        # Jumps so fast that a velocity would overflow are refused; after the fastest that are taken,
        # what follows must be felt as ever.
        for jump in ([(0, 0, 0, 0.03), (5e-324, 0.1, 0, 0.03)], [(0, 1e308, 0, 0.03), (1, -1e308, 0, 0.03)],
                     [(-1e308, 0, 0, 0.03), (-1, 0, 0, 0.03)]):
            self.write("path.csv", path_csv(jump))
            self.refuse(1, "path.csv: line", "replay", "wall.ply", "--trajectory", "path.csv", "--out", "run.csv")
        for jump in ([(0, 1e12, 0, 0.03), (2e-9, -1e12, 0, 0.03)], [(-1e12, 0, 0, 0.03), (-1, 0, 0, 0.03)]):
            later = [(1 + 0.1 * k, 0, 0, 0.03) for k in range(20)]
            _, run = self.replay(path_csv(jump + later))
            for name, values in columns_of(run).items():
                for value in values:
                    self.assertTrue(math.isfinite(float(value)), (jump, name, value))
            self.assertGreater(float(columns_of(run)["fz"][-1]), 0)
            self.succeed("report", "run.csv", "--out", "page.html")  # reads what replay writes

    def test_quiet_is_silent(self):
        result, _ = self.replay(tapping_path(), "-q")
        self.assertEqual((result.out, result.err), (b"", b""))
        result, _ = self.replay(tapping_path(), "--quiet")
        self.assertEqual((result.out, result.err), (b"", b""))

    def test_no_progress_where_there_is_no_terminal(self):
        result, _ = self.replay(tapping_path())
        self.assertEqual(result.err, b"")
        self.assertIn(b"wrote run.csv", result.out)


if __name__ == "__main__":
    unittest.main()
