"""Replay is deterministic: the same bytes every time, on any number of threads."""

import unittest

from support import Case, columns_of, ply, random_rows, tapping_path, wall_rows


def without_time(run):
    columns = columns_of(run)
    times = columns.pop("compute_us")
    assert all(float(t) > 0 for t in times)
    return columns


class Determinism(Case):
    def setUp(self):
        super().setUp()
        self.write("a.ply", ply(wall_rows() + random_rows(400, 3)))
        self.write("path.csv", tapping_path(5000, 5000.0))

    def replay(self, *args):
        self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv", "-q", *args)
        return without_time(self.read("run.csv"))

    def test_runs_and_threads_change_nothing_but_the_time(self):
        first = self.replay()
        self.assertGreater(sum(int(n) > 0 for n in first["colliding"]), 1000)
        for threads in (None, 1, 2, 4):
            self.assertEqual(first, self.replay(*(["--threads", str(threads)] if threads else [])))

    def test_so_is_the_papers_pipeline(self):
        args = ["--pipeline", "paper", "--search-radius", "0.2"]
        first = self.replay(*args)
        self.assertEqual(first, self.replay(*args, "--threads", "2"))
        exact = self.replay()
        self.assertEqual(first["colliding"], exact["colliding"])
        self.assertNotEqual(first["candidates"], exact["candidates"])

    def test_the_papers_pipeline_reports_what_it_can_miss(self):
        result = self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv", "--json",
                              "--pipeline", "paper", "--search-radius", "0.05")
        self.assertEqual(result.json["search_radius"], 0.05)
        self.assertGreater(result.json["can_miss"], 0)
        text = self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv",
                            "--pipeline", "paper", "--search-radius", "0.05").out.decode()
        self.assertIn(f"can miss {result.json['can_miss']} Gaussians", text)


if __name__ == "__main__":
    unittest.main()
