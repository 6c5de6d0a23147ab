"""The report page: self-contained, inert to hostile names, and true to its run."""

import html.parser
import json
import os
import re
import unittest
from xml.etree import ElementTree

from support import LIVE_HEADER, Case, columns_of, head_of, path_csv, ply, random_rows, table_of, tapping_path, wall_rows

LOADING_ATTRIBUTES = {"src", "href", "srcset", "action", "formaction", "poster", "data", "background", "ping"}
RUN_COLUMNS = ("t x y z qw qx qy qz candidates filtered colliding k_max fx fy fz tx ty tz px py pz "
               "compute_us").split()


class Page(html.parser.HTMLParser):
    """The title, the JSON document, and every address that a tag could load."""

    def __init__(self, text):
        super().__init__()
        self.title, self.document, self.addresses, self.tags = "", "", [], []
        self._where = None
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.tags.append(tag)
        self.addresses += [value for name, value in attrs.items() if name in LOADING_ATTRIBUTES]
        if tag == "title":
            self._where = "title"
        elif tag == "script" and attrs.get("type") == "application/json":
            self._where = "document"

    def handle_endtag(self, tag):
        self._where = None

    def handle_data(self, data):
        if self._where:
            setattr(self, self._where, getattr(self, self._where) + data)


class Report(Case):
    def setUp(self):
        super().setUp()
        self.write("a.ply", ply(wall_rows() + random_rows(100, 5)))
        self.write("path.csv", tapping_path(600))
        self.replay("run.csv")

    def replay(self, out):
        self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", out, "-q")

    def report(self, run="run.csv", *args):
        self.succeed("report", run, "--out", "page.html", "-q", *args)
        return Page(self.read("page.html").decode())

    def test_the_columns_are_those_of_the_run(self):
        document = json.loads(self.report().document)
        run = columns_of(self.read("run.csv"))
        self.assertEqual(list(document["columns"]), RUN_COLUMNS)
        for name, values in run.items():
            shown = document["columns"][name]
            self.assertEqual(len(shown), 600)
            for a, b in zip(shown, values):
                digits = 1e-3 if name == "compute_us" else 1e-6
                self.assertLessEqual(abs(a - float(b)), digits * abs(float(b)), name)
        self.assertEqual(document["title"], "run.csv")
        self.assertEqual(len(document["episodes"]), 2)
        for episode in document["episodes"]:
            first, last = episode["first"], episode["last"]
            self.assertGreater(int(run["colliding"][first]), 0)
            self.assertEqual(episode["onset_t"], float(run["t"][first]))
            self.assertEqual(episode["peak_colliding"], max(int(n) for n in run["colliding"][first:last + 1]))
        self.assertIsNone(document["contacts"])
        self.assertIsNone(document["scene"])

    def test_the_settings_of_the_scene_are_those_of_the_run(self):
        settings = ["--scale", "2", "--tool", "0.03,0.03,0.03", "--opacity-min", "0.3", "--sigma", "1.2"]
        self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv", "-q", *settings)
        said = json.loads(self.report("run.csv", "--scene", "a.ply", *settings).document)
        os.makedirs(os.path.join(self.folder, "elsewhere"))
        for name in ("a.ply", "run.csv"):
            os.rename(os.path.join(self.folder, name), os.path.join(self.folder, "elsewhere", name))
        run = os.path.join("elsewhere", "run.csv")
        scene = ["--scene", os.path.join("elsewhere", "a.ply")]
        own = json.loads(self.report(run, *scene).document)
        for part in ("contacts", "scene", "tool"):
            self.assertEqual(own[part], said[part], part)
        other = json.loads(self.report(run, *scene, "--tool", "0.05,0.05,0.05").document)
        self.assertNotEqual(other["tool"], said["tool"])
        self.assertEqual(other["scene"], said["scene"])
        self.succeed("report", *scene, "--out", "page.html", "-q", run)  # in any order
        self.assertEqual(json.loads(Page(self.read("page.html").decode()).document)["tool"], said["tool"])

    def test_a_scene_adds_points_and_contacts(self):
        document = json.loads(self.report("run.csv", "--scene", "a.ply").document)
        run = columns_of(self.read("run.csv"))
        rows = document["contacts"]["row"]
        for row in set(rows):
            self.assertEqual(rows.count(row), int(run["colliding"][row]))
        self.assertEqual(len(rows), sum(int(n) for n in run["colliding"]))
        self.assertEqual(len(document["scene"]["points"]), len(document["scene"]["colors"]))
        self.assertEqual([part["semi_axes"] for part in document["tool"]], [[0.02, 0.02, 0.04]])
        for n in zip(*(document["contacts"][k] for k in ("nx", "ny", "nz"))):
            self.assertAlmostEqual(sum(c * c for c in n), 1, delta=0.01)

    def test_the_page_says_how_the_run_was_made(self):
        self.assertEqual(json.loads(self.report().document)["made"], head_of(self.read("run.csv")))
        self.write("bare.csv", table_of(self.read("run.csv")))
        self.assertEqual(json.loads(self.report("bare.csv").document)["made"], "")
        self.write("odd.csv", "# </script><b>\n" + table_of(self.read("run.csv")))
        self.assertEqual(json.loads(self.report("odd.csv").document)["made"], "</script><b>\n")

    def test_runs_are_drawn_over_one_another(self):
        self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--model", "field", "--out", "field.csv", "-q")
        self.write("late.csv", path_csv([(5 + k / 100, 0, 0, 0.03) for k in range(10)]))
        self.succeed("replay", "a.ply", "--trajectory", "late.csv", "--out", "late run.csv", "-q")
        document = json.loads(self.report("run.csv", "field.csv", "late run.csv").document)
        self.assertEqual((document["title"], len(document["columns"]["t"])), ("run.csv", 600))
        self.assertEqual([other["title"] for other in document["others"]], ["field.csv", "late run.csv"])
        field, late = document["others"]
        self.assertEqual(list(field["columns"]), ["t", "colliding", "fx", "fy", "fz", "compute_us"])
        self.assertEqual(field["made"], head_of(self.read("field.csv")))
        written = columns_of(self.read("field.csv"))
        for shown, value in zip(field["columns"]["fz"], written["fz"], strict=True):
            self.assertAlmostEqual(shown, float(value), delta=1e-6 * abs(float(value)))
        self.assertEqual(late["columns"]["t"][0], 5)
        self.assertEqual(late["summary"][0], {"label": "Poses", "value": "10"})
        self.assertNotIn("others", json.loads(self.report().document))
        self.refuse(1, "field.csv", "report", "run.csv", "field.csv", "--out", "field.csv")
        self.refuse(1, "no.csv", "report", "run.csv", "no.csv", "--out", "page.html")

    def test_figures_are_written_as_files(self):
        os.mkdir(self.path("one"))
        out = self.succeed("report", "run.csv", "--out", "page.html", "--svg", "one").out.decode()
        names = [f"report-{name}.svg" for name in ("compute", "counts", "force")]
        self.assertEqual(sorted(os.listdir(self.path("one"))), names)
        for name in names:
            self.assertIn(name, out)
            texts = [text for text in ElementTree.fromstring(self.read(f"one/{name}")).itertext()]
            self.assertTrue(any("run.csv" in text for text in texts), name)
        self.succeed("report", "run.csv", "run.csv", "--html", "page.html", "--svg", "one", "-q")
        self.refuse(1, "--svg", "report", "run.csv", "--out", "page.html", "--svg", "nowhere")

    def test_another_scene_is_refused(self):
        self.write("b.ply", ply(random_rows(50, 6)))
        command = ("report", "run.csv", "--out", "page.html", "-q", "--scene")
        words = ["run.csv", "another scene than", "xxh3-16MiB:", "omit --scene"]
        self.refuse(1, words, *command, "b.ply")
        self.assertFalse(os.path.exists(self.path("page.html")))
        os.rename(self.path("a.ply"), self.path("kept.ply"))
        self.succeed(*command, "kept.ply")
        self.write("a.ply", self.read("b.ply"))  # under the name that the run has recorded
        self.refuse(1, words, *command, "a.ply")

    def test_another_scene_of_a_run_without_a_checksum_is_noticed(self):
        self.write("b.ply", ply(random_rows(50, 6)))
        self.write("run.csv", table_of(self.read("run.csv")))
        result = self.succeed("report", "run.csv", "--scene", "b.ply", "--out", "page.html", "-q")
        self.assertIn(b"have other contacts", result.err)
        self.assertEqual(self.succeed("report", "run.csv", "--scene", "a.ply", "--out", "page.html", "-q").err, b"")

    def test_a_user_force_is_shown(self):
        self.write("path.csv", "t,x,y,z,ufx,ufy,ufz\n0,0,0,0.02,1,2,3\n1,0,0,0.01,4,5,6\n")
        self.replay("run.csv")
        document = json.loads(self.report().document)
        self.assertEqual(document["columns"]["ufy"], [2, 5])

    def test_a_cut_recording_is_shown_up_to_where_it_is_cut(self):
        text = self.read("run.csv")
        self.write("cut.csv", text[:text.rindex(b",")])
        result = self.succeed("report", "cut.csv", "--out", "page.html", "-q")
        self.assertEqual(result.err, b"palpate: cut.csv: the last line is truncated and ignored (the recording was interrupted)\n")
        document = json.loads(Page(self.read("page.html").decode()).document)
        self.assertEqual(len(document["columns"]["t"]), 599)

    def test_a_part_of_a_run(self):
        document = json.loads(self.report("run.csv", "--from", "0.1", "--to", "0.2").document)
        self.assertEqual(document["columns"]["t"], [k / 1000 for k in range(100, 201)])
        self.assertEqual(json.loads(self.report("run.csv", "--from", "0.5").document)["columns"]["t"][0], 0.5)
        self.assertEqual(json.loads(self.report("run.csv", "--to", "0.5").document)["columns"]["t"][-1], 0.5)

    def test_a_live_run_tells_what_the_governor_did(self):
        header, *lines = table_of(self.read("run.csv")).splitlines()
        # (state, fault) from row to row: waiting, active, falling and stopped for over-speed, waiting, and a jump
        # that comes on top of a stale pose.
        changes = {0: (0, 0), 5: (2, 0), 100: (3, 5), 130: (4, 5), 300: (0, 0), 400: (3, 2), 401: (3, 4)}
        text, now = header + LIVE_HEADER + "\n", None
        for k, line in enumerate(lines):
            now = changes.get(k, now)
            text += f"{line},1,2,2,0,0,0,3,0,4,0,0,0,{now[0]},{now[1]},0.125,0.25,0,1.5,{k}\n"
        self.write("live.csv", text)
        document = json.loads(self.report("live.csv").document)
        shown = document["columns"]
        self.assertEqual(list(shown), RUN_COLUMNS + "vx vy vz sfx sfy sfz state fault energy stored age_us".split())
        self.assertEqual((shown["vy"][7], shown["sfz"][7], shown["energy"][7], shown["age_us"][7]), (2, 4, 0.125, 7))
        governor = document["governor"]
        self.assertEqual(governor["row"], list(changes))
        self.assertEqual(governor["t"], [k / 1000 for k in changes])
        self.assertEqual(list(zip(governor["state"], governor["fault"])), list(changes.values()))
        self.assertEqual(governor["states"], ["waiting", "rising", "active", "falling", "stopped"])
        self.assertEqual(governor["faults"][5], "over-speed")
        self.assertEqual(governor["faults"][13:], ["emergency-stop", "late-tick", "crowded", "stalled", "force-sensor", "not-following", "ended"])  # recordings have the numbers
        self.assertIn({"label": "Faults", "value": "3"}, document["summary"])

    def test_a_replay_has_no_governor(self):
        document = json.loads(self.report().document)
        self.assertIsNone(document["governor"])
        self.assertNotIn("Faults", [item["label"] for item in document["summary"]])

    def test_nothing_is_loaded_from_anywhere(self):
        page = self.report("run.csv", "--scene", "a.ply")
        for address in page.addresses:
            self.assertTrue((address or "").startswith(("data:", "#", "blob:")), address)
        for tag in ("link", "iframe", "object", "embed", "base"):
            self.assertNotIn(tag, page.tags)
        text = self.read("page.html").decode()
        for call in (r"\bimport\s*\(", r"@import", r"url\(\s*['\"]?(?:https?:)?//", r"importScripts\("):
            self.assertIsNone(re.search(call, text), call)

    def test_a_hostile_name_is_inert(self):
        for name in ("</script><script>alert(1)</script>.csv".replace("/", "\u2215"), "<!--<script>.csv",
                     "<\\script><b onload=x>&amp;\"'.csv", "<!--PALPATE_RUN_JSON-->.csv", "$&$1\\u0041.csv",
                     "a\nb\x1b[31m\u2028.csv"):
            with self.subTest(name):
                self.replay(name)
                page = self.report(name)
                document = json.loads(page.document)
                self.assertEqual(document["title"], name)
                self.assertEqual(page.title, name.replace("\n", "?").replace("\x1b", "?").replace("\u2028", "???"))
                self.assertNotIn("b", page.tags)
                self.assertEqual(page.tags, self.report("run.csv").tags)

    def test_a_folder_may_end_a_script_element(self):
        os.mkdir(self.path("<"))  # makes the name below a path that exists
        name = "</script><script>alert(1)<"
        self.replay(name)
        page = self.report(name)
        json.loads(page.document)
        self.assertEqual(page.tags, self.report("run.csv").tags)

    def test_a_name_that_is_not_utf8(self):
        name = b"run-\xff\xfe.csv"
        self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", name, "-q")
        self.succeed("report", name, "--out", "page.html", "-q")
        page = Page(self.read("page.html").decode("utf-8", "replace"))
        self.assertEqual(json.loads(page.document)["title"], "run-\ufffd\ufffd.csv")
        self.read("page.html").decode()  # the page says that it is UTF-8, so it must be

    def test_hostile_runs_are_drawn_or_refused_but_end(self):
        header, row = table_of(self.read("run.csv")).split("\n")[:2]
        cells = row.split(",")
        for changes in ({4: "0", 5: "0", 6: "0", 7: "0"}, {1: "1e308", 2: "-1e308"}, {3: "1e-320"}, {12: "1e300"},
                        {8: "4294967295"}):
            changed = list(cells)
            for k, value in {10: "1", **changes}.items():
                changed[k] = value
            self.write("odd.csv", header + "\n" + ",".join(changed) + "\n")
            result = self.run_palpate("report", "odd.csv", "--scene", "a.ply", "--out", "page.html", "-q")
            self.assertIn(result.code, (0, 1), (changes, result.err))
            if result.code == 0:
                json.loads(Page(self.read("page.html").decode()).document, parse_constant=self.fail)


if __name__ == "__main__":
    unittest.main()
