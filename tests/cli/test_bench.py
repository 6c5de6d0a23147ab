"""palpate bench: figures that agree with each other and with replay. How long anything takes is never asserted."""

import re
import unittest
import xml.etree.ElementTree as ElementTree

from support import Case, columns_of, path_csv, ply, rows_of, tapping_path, wall_rows

KEYS = ["machine", "scene", "scene_bytes", "gaussians", "pipeline", "simd", "model", "tool", "open", "path", "poses",
        "contact_poses", "rounds", "latency_us", "sizes", "throughput", "made"]
PHASES = ["query_contact", "query_free", "tracker_contact", "force_contact"]
QUANTILES = ["p50", "p99", "p99.9", "max"]


class Bench(Case):
    def setUp(self):
        super().setUp()
        self.write("wall.ply", ply(wall_rows()))
        self.write("path.csv", tapping_path())

    def bench(self, *args):
        return self.succeed("bench", "wall.ply", "--trajectory", "path.csv", *args)

    def figures(self, *args):
        return self.bench("--json", *args).json


class Figures(Bench):
    def test_the_keys_are_those_of_the_contract(self):
        figures = self.figures()
        self.assertEqual(list(figures), KEYS)
        self.assertEqual(list(figures["open"]), ["seconds", "origin", "remarks", "index_bytes", "bytes_per_gaussian",
                                                 "peak_rss_bytes"])
        self.assertEqual(list(figures["latency_us"]), PHASES)
        for phase in PHASES:
            self.assertEqual(list(figures["latency_us"][phase]), ["count", *QUANTILES])
        self.assertEqual(list(figures["sizes"]), ["contacts", "filtered", "candidates"])
        self.assertEqual(list(figures["throughput"]), ["threads", "queries_per_second", "in_contact"])

    def test_counts_are_those_of_replay(self):
        figures = self.figures()
        self.succeed("replay", "wall.ply", "--trajectory", "path.csv", "--out", "run.csv", "-q")
        run = columns_of(self.read("run.csv"))
        touching = [k for k, n in enumerate(run["colliding"]) if int(n) > 0]
        self.assertTrue(0 < len(touching) < 400)
        self.assertEqual((figures["poses"], figures["contact_poses"]), (400, len(touching)))
        counts = {phase: figures["latency_us"][phase]["count"] for phase in PHASES}
        self.assertEqual(counts.pop("query_free"), 400 - len(touching))
        self.assertEqual(set(counts.values()), {len(touching)})
        for key, column in {"contacts": "colliding", "filtered": "filtered", "candidates": "candidates"}.items():
            sizes = sorted(int(run[column][k]) for k in touching)
            self.assertEqual(figures["sizes"][key]["max"], sizes[-1])
            self.assertIn(figures["sizes"][key]["median"], sizes)

    def test_figures_are_in_order(self):
        figures = self.figures("--rounds", "2")
        self.assertEqual(figures["rounds"], 2)
        for phase in PHASES:
            times = [figures["latency_us"][phase][q] for q in QUANTILES]
            self.assertEqual(times, sorted(times))
            self.assertGreater(times[0], 0)
        self.assertGreater(figures["throughput"]["queries_per_second"], 0)
        self.assertEqual(figures["throughput"]["in_contact"], True)
        self.assertEqual(figures["tool"], [{"name": "tool", "semi_axes": [0.02, 0.02, 0.04], "position": [0, 0, 0],
                                            "orientation": [1, 0, 0, 0]}])
        self.assertEqual(figures["model"], "proxy")
        self.assertEqual((figures["scene"], figures["path"]), ("wall.ply", "path.csv"))

    def test_where_the_index_comes_from(self):
        first, second = self.figures(), self.figures()
        self.assertEqual((first["open"]["origin"], second["open"]["origin"]), ("new index file", "index file"))
        self.assertEqual(self.figures("--no-index-file")["open"]["origin"], "memory")
        self.assertEqual(first["gaussians"], 441)
        self.assertEqual(first["scene_bytes"], len(self.read("wall.ply")))
        self.assertEqual(first["open"]["bytes_per_gaussian"], first["open"]["index_bytes"] / 441)
        self.assertGreater(first["open"]["peak_rss_bytes"], first["open"]["index_bytes"])

        self.write("wall.ply.palpate", "not a palpate index")
        damaged = self.figures()["open"]
        self.assertEqual((damaged["origin"], len(damaged["remarks"])), ("new index file", 1))
        self.assertIn("wall.ply.palpate", damaged["remarks"][0])

    def test_without_a_path_one_is_made(self):
        self.succeed("make-scene", "sphere", "--out", "s.ply", "-q")
        figures = self.succeed("bench", "s.ply", "--rounds", "1", "--json").json
        self.assertIsNone(figures["path"])
        self.assertGreater(figures["contact_poses"], 0)
        self.succeed("make-path", "s.ply", "--out", "p.csv", "-q")
        self.assertEqual(figures["poses"], len(rows_of(self.read("p.csv"))))

    def test_the_papers_pipeline_has_neither_tracker_nor_index(self):
        figures = self.figures("--pipeline", "paper", "--search-radius", "0.5")
        self.assertEqual(figures["pipeline"], "paper")
        self.assertIsNone(figures["latency_us"]["tracker_contact"])
        self.assertIsNone(figures["open"]["index_bytes"])
        self.assertEqual(figures["gaussians"], 441)
        self.assertEqual(figures["contact_poses"], self.figures()["contact_poses"])


class AtTheEdge(Bench):
    def test_a_path_that_never_touches(self):
        self.write("path.csv", path_csv([(0.1 * k, 0, 0, 5 + k) for k in range(5)]))
        figures = self.figures("--histogram", "h.svg")
        self.assertEqual((figures["poses"], figures["contact_poses"], figures["sizes"]), (5, 0, None))
        for phase in PHASES:
            self.assertEqual(figures["latency_us"][phase] is None, phase != "query_free")
        self.assertEqual(figures["throughput"]["in_contact"], False)
        self.assertIn(b"never touches", self.bench().out)
        self.assertIn(b"5 poses out of contact", self.read("h.svg"))

    def test_a_path_that_always_touches(self):
        self.write("path.csv", path_csv([(0, 0, 0, 0.03)]))
        figures = self.figures("--histogram", "h.svg")
        self.assertEqual((figures["poses"], figures["contact_poses"]), (1, 1))
        self.assertIsNone(figures["latency_us"]["query_free"])

    def test_nothing_to_touch(self):
        self.refuse(1, ["wall.ply", "no Gaussian passes the filter"], "bench", "wall.ply", "--trajectory", "path.csv",
                    "--opacity-min", "1")

    def test_refusals(self):
        self.refuse(1, "missing.ply", "bench", "missing.ply")
        self.refuse(1, "missing.csv", "bench", "wall.ply", "--trajectory", "missing.csv")
        self.refuse(2, ["--simd", "AVX9"], "bench", "wall.ply", "--simd", "AVX9")
        for bad in (["--rounds", "0"], ["--threads", "0"], ["--rounds", "x"]):
            self.refuse(2, bad[0], "bench", "wall.ply", *bad)
        self.refuse(1, ["missing/h.svg", "No such file"], "bench", "wall.ply", "--trajectory", "path.csv", "--rounds",
                    "1", "--histogram", "missing/h.svg")
        before = self.read("path.csv")
        self.refuse(1, "path.csv", "bench", "wall.ply", "--trajectory", "path.csv", "--histogram", "path.csv")
        self.assertEqual(self.read("path.csv"), before)


class Options(Bench):
    def test_every_instruction_set_finds_the_same(self):
        best = self.figures()
        refusal = self.refuse(2, "--simd", "bench", "wall.ply", "--simd", "none").err.decode()
        names = re.search(r"{(.*)}", refusal).group(1).split(",")
        self.assertEqual(names[0], best["simd"])
        for name in names:
            figures = self.figures("--simd", name)
            self.assertEqual(figures["simd"], name)
            self.assertEqual(figures["sizes"]["contacts"], best["sizes"]["contacts"])

    def test_threads_are_for_the_throughput(self):
        for threads in (1, 2):
            self.assertEqual(self.figures("--threads", str(threads))["throughput"]["threads"], threads)

    def test_text(self):
        text = self.bench().out.decode()
        for words in ("fresh query, in contact", "tracker, in contact", "force model, in contact", "candidates",
                      "queries/s", "bytes per Gaussian", "new index file"):
            self.assertIn(words, text)
        self.assertNotIn("####", text)  # the histogram is for terminals

    def test_quiet_is_silent(self):
        result = self.bench("-q", "--histogram", "h.svg")
        self.assertEqual((result.out, result.err), (b"", b""))
        self.assertIn("h.svg", self.files())


class Histogram(Bench):
    NAMESPACE = "{http://www.w3.org/2000/svg}"

    def svg(self, scene="wall.ply"):
        self.succeed("bench", scene, "--trajectory", "path.csv", "--rounds", "1", "--histogram", "h.svg", "-q")
        return ElementTree.fromstring(self.read("h.svg"))

    def test_it_is_a_picture_that_needs_nothing_else(self):
        root = self.svg()
        self.assertEqual(root.tag, self.NAMESPACE + "svg")
        self.assertNotIn(b"href", self.read("h.svg"))
        text = " ".join(element.text or "" for element in root.iter(self.NAMESPACE + "text"))
        for words in ("p50 = ", "p99 = ", "p99.9 = ", "\u00b5s", "wall.ply"):
            self.assertIn(words, text)

    def test_bars_are_inside_and_there(self):
        bars = [e for e in self.svg().iter(self.NAMESPACE + "rect") if e.get("class") == "bar"]
        self.assertGreater(len(bars), 0)
        for bar in bars:
            x, y, width, height = (float(bar.get(k)) for k in ("x", "y", "width", "height"))
            self.assertTrue(0 < x and x + width < 860 and 0 < y and y + height < 440)
            self.assertGreater(height, 1)

    def test_a_file_name_is_text(self):
        self.write("a<b>&c.ply", ply(wall_rows()))
        text = " ".join(element.text or "" for element in self.svg("a<b>&c.ply").iter(self.NAMESPACE + "text"))
        self.assertIn("a<b>&c.ply", text)


if __name__ == "__main__":
    unittest.main()
