"""palpate reproduce: the paper's evaluation by one command."""

import unittest

from support import Case, stood_still, table_of

# A scene and a path that are small enough for a test.
QUICK = ("--touches", "2", "--stall", "0")


class Reproduce(Case):
    def setUp(self):
        super().setUp()
        self.succeed("make-scene", "box", "--out", "box.ply", "-q")

    def test_feels_a_scene_of_ones_own_on_both_devices(self):
        result = self.succeed("reproduce", "box.ply", *QUICK, "--json", "--html", "page.html", "--csv", "ticks.csv").json
        names = [(run["model"], run["device"]) for run in result["runs"]]
        self.assertEqual(names, [(model, device) for device in ("admittance", "impedance") for model in ("density", "proxy")])
        for run in result["runs"]:
            self.assertEqual(run["faults"], [])
            self.assertEqual(len(run["contacts"]), 2)
        for contact in result["runs"][1]["contacts"]:
            self.assertGreater(contact["force"], 1)
            self.assertLess(contact["swing_mm"], 0.05)
            self.assertAlmostEqual(contact["user_force"], contact["force"], delta=0.05 * contact["force"])
            self.assertIsNone(contact["true_depth_mm"])  # nobody knows the surface of a file
        self.assertEqual(len(result["claims"]), 15)
        seven = next(claim for claim in result["claims"] if "Seven" in claim["paper"])
        self.assertEqual((seven["figure"], seven["bound"], seven["default"], seven["met"]), ("7", ">= 7", 2, False))
        page = self.read("page.html").decode()
        self.assertNotIn("http://", page.replace("http://www.w3.org", ""))
        for part in ("TCP path from above", "Repulsive force", "User force", "Computation time", ">tb<"):
            self.assertIn(part, page)
        rows = table_of(self.read("ticks.csv")).splitlines()
        self.assertEqual(rows[0].split(",")[:3], ["run", "t", "x"])
        self.assertEqual({row.split(",")[0] for row in rows[1:]}, {"density", "proxy"})

    def test_angles_to_a_normal_that_nobody_knows_are_not_figures(self):
        text = self.succeed("reproduce", "box.ply", *QUICK).out.decode()
        header, *rows = text[text.index("\nrun  "):].strip().split("\n")
        end = header.index("angle deg") + len("angle deg")
        self.assertEqual(len(rows), 4)
        for row in rows:
            self.assertEqual(row[:end].split()[-1], "-", row)
            self.assertEqual(row[end:].split()[0], "-", row)

    def test_says_what_cannot_be_done(self):
        for arguments, words in (
            (("--virtual-damping", "1", "--stiffness", "5000"), "not stable"),
            (("--translate", "0,0,50"), "can be reached"),
            (("--chain", "nothing.toml"), "nothing.toml"),
            (("--csv", "box.ply"), "is also an input"),
            (("--html", "box.ply"), "is also an input"),
        ):
            with self.subTest(arguments=arguments):
                self.refuse(1, words, "reproduce", "box.ply", *QUICK, *arguments)


class RunOnTheGiant(Case):
    def test_feels_the_built_in_scene_and_records_the_users_force(self):
        for k in range(3):  # a late tick takes the force away, and with it what is touched until the hand lets go
            run = self.succeed("run", "--device", "giant", "--no-gateway", "--seconds", "14", "--record", f"giant-{k}.csv", "--json").json
            if "late-tick" not in run["faults"]:
                break
        self.assertGreater(run["contact_ticks"], 0)
        self.assertGreater(run["force_max"], 0.5)
        if stood_still(run) < 10_000:  # a force that is held meanwhile does work
            self.assertLess(run["port_energy"], 1e-3)
        names, *rows = table_of(self.read(f"giant-{k}.csv")).splitlines()
        column = names.split(",").index("ufz")
        self.assertGreater(max(abs(float(row.split(",")[column])) for row in rows), 0.5)

    def test_refuses_what_is_not_stable_before_anything_moves(self):
        result = self.run_palpate("run", "--device", "giant", "--no-gateway", "--seconds", "1", "--virtual-damping", "1",
                                  "--stiffness", "5000")
        self.assertEqual(result.code, 1)
        self.assertIn(b"needs a damping of", result.err)


if __name__ == "__main__":
    unittest.main()
