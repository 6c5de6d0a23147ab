"""Options from a TOML file."""

import unittest

from support import Case, ply, random_rows, tapping_path


class Config(Case):
    def setUp(self):
        super().setUp()
        self.write("a.ply", ply(random_rows(300, 2)))
        self.write("path.csv", tapping_path(20))

    def query(self, *args):
        return self.succeed("query", "a.ply", "--pose", "0.01,0,0", "--json", *args).figures

    def with_config(self, text, *args):
        self.write("c.toml", text)
        return self.query("--config", "c.toml", *args)

    def refuse_config(self, text, words, *args):
        self.write("c.toml", text)
        args = args or ("query", "a.ply", "--pose", "0,0,0")
        return self.refuse(1, ["c.toml", *([words] if isinstance(words, str) else words)], *args, "--config", "c.toml")

    def test_keys_are_long_options(self):
        self.assertEqual(self.with_config("sigma = 2\n"), self.query("--sigma", "2"))
        self.assertEqual(self.with_config("sigma = 2.5\nopacity-min = 0.4"),
                         self.query("--sigma", "2.5", "--opacity-min", "0.4"))
        self.assertEqual(self.with_config('frame = "y-up"'), self.query("--frame", "y-up"))
        self.write("c.toml", "sigma = 2\n")
        self.assertEqual(self.query("--config=c.toml"), self.query("--sigma", "2"))

    def test_arrays_are_vectors(self):
        wanted = self.query("--tool", "0.01,0.02,0.03", "--translate", "-0.01,0,2e-3")
        self.assertEqual(self.with_config("tool = [0.01, 0.02, 0.03]\ntranslate = [-0.01, 0, 2e-3]"), wanted)
        self.assertEqual(self.with_config('tool = "0.01,0.02,0.03"\ntranslate = "-0.01,0,0.002"'), wanted)

    def test_a_tool_of_many_may_stand_in_it(self):
        text = "[[ellipsoid]]\nname = 'a'\nsemi_axes = [0.01, 0.02, 0.03]\nposition = [0.01, 0, 0]\n"
        self.write("tool.toml", text)
        self.assertEqual(self.with_config(f'tool = """\n{text}"""'), self.query("--tool", "tool.toml"))
        self.assertEqual(self.query("--tool", text), self.query("--tool", "tool.toml"))
        self.refuse(1, ["--tool", "line 1", "'name' is missing"], "query", "a.ply", "--pose", "0,0,0", "--tool", "[[ellipsoid]]\n")

    def test_numbers_lose_no_digit(self):
        self.assertEqual(self.with_config("sigma = 1.2345678901234567"), self.query("--sigma", "1.2345678901234567"))

    def test_flags(self):
        self.write("c.toml", "json = true\nquiet = true")
        self.assertEqual(self.succeed("query", "a.ply", "--pose", "0.01,0,0", "--config", "c.toml").figures, self.query())
        text = self.succeed("query", "a.ply", "--pose", "0.01,0,0").out
        self.write("c.toml", "json = false")
        self.assertEqual(self.succeed("query", "a.ply", "--pose", "0.01,0,0", "--config", "c.toml").out, text)
        self.refuse_config("json = 1", ["line 1", "json"])

    def test_required_options_may_come_from_it(self):
        self.write("c.toml", 'pose = [0.01, 0, 0]\ntrajectory = "path.csv"\nout = "run.csv"')
        self.assertEqual(self.succeed("query", "a.ply", "--json", "--config", "c.toml").figures, self.query())
        self.succeed("replay", "a.ply", "-q", "--config", "c.toml")
        self.assertIn("run.csv", self.files())

    def test_the_command_line_wins(self):
        self.assertEqual(self.with_config("sigma = 2", "--sigma", "3"), self.query("--sigma", "3"))
        self.assertEqual(self.with_config("sigma = 2", "--sigma=3"), self.query("--sigma", "3"))
        self.assertEqual(self.with_config("sigma = 2", "--iso", "0.2"), self.query("--iso", "0.2"))
        self.assertEqual(self.with_config("iso = 0.2", "--sigma", "2"), self.query("--sigma", "2"))

    def test_keys_of_other_commands_are_left_alone(self):
        self.assertEqual(self.with_config("threads = 2\nsigma = 2\nnoise = 0.1"), self.query("--sigma", "2"))

    def test_unknown_keys_are_named(self):
        self.refuse_config("sigma = 1\n\nsigmma = 2\n", ["line 3", "sigmma"])
        self.refuse_config("SCENE = 'a.ply'", ["line 1", "SCENE"])
        self.refuse_config("config = 'c.toml'", ["line 1", "config"])
        self.refuse_config("help = true", ["line 1", "help"])
        self.refuse_config('"" = 1', "line 1")
        self.refuse_config('"pose=0,0,0" = 1', "line 1")
        self.refuse_config('"-sigma" = 1', "line 1")

    def test_bad_values_name_file_and_line(self):
        for text in ("sigma = -1", "sigma = 0", "sigma = nan", "sigma = inf", "sigma = true", 'sigma = "x"',
                     "sigma = [1, 2]", "sigma = []", 'sigma = ""', "tool = [1, 2]", "tool = [0, 0, 0]",
                     "tool = [1, [2], 3]", "rotate = [0, 0, 0, 0]", 'model = "magic"', 'frame = "w-up"',
                     "iso = 1", "sigma = 2001-01-01", "sigma = {a = 1}", "iterations = 0", "iterations = 1.5",
                     "k-base = -1"):
            with self.subTest(text):
                self.refuse_config("# a comment\n\n" + text + "\n", "line 3")
        self.refuse_config('threads = "many"', "line 1", "replay", "a.ply", "--trajectory", "path.csv", "--out", "r.csv")
        self.refuse_config("\nthreads = 0", "line 2", "replay", "a.ply", "--trajectory", "path.csv", "--out", "r.csv")
        self.refuse_config("[scene]\nsigma = 1\n", ["line 1", "scene"])
        self.refuse_config("a.b = 1", ["line 1", "'a'"])

    def test_sigma_and_iso_exclude_each_other(self):
        self.refuse(2, ["--sigma", "--iso"], "query", "a.ply", "--pose", "0,0,0", "--sigma", "2", "--iso", "0.2")
        self.refuse_config("sigma = 2\niso = 0.2", ["line", "iso", "sigma"])

    def test_the_scene_may_be_in_the_file(self):
        self.write("c.toml", 'scene = "a.ply"\n')
        self.assertEqual(self.succeed("query", "--pose", "0.01,0,0", "--json", "--config", "c.toml").figures, self.query())
        self.write("c.toml", 'scene = "missing.ply"\n')
        self.assertEqual(self.with_config('scene = "missing.ply"'), self.query(), "the argument has precedence")
        self.refuse(1, "missing.ply", "info", "--config", "c.toml")

    def test_what_is_not_toml_names_the_line(self):
        for text in ("sigma = ", "= 1", "sigma 1", "sigma = 1\nsigma = 2", "sigma = 1 2", 'frame = "y-up', "\x00",
                     "sigma = 0x", "[[", "a = '''", "sigma = 1__0", "\xff\xfe"):
            with self.subTest(text):
                self.refuse_config(text.encode("latin-1"), "line ")

    def test_the_file_itself(self):
        query = ("query", "a.ply", "--pose", "0,0,0", "--config")
        self.refuse(1, "missing.toml", *query, "missing.toml")
        self.refuse(1, "folder", *query, ".")
        self.refuse(2, "--config", *query)
        self.write("large.toml", "#" * (2 << 20))
        self.refuse(1, "large.toml", *query, "large.toml")
        self.assertEqual(self.with_config(""), self.query())
        self.assertEqual(self.with_config("# nothing\r\n\r\n"), self.query())
        self.assertEqual(self.with_config(b"\xef\xbb\xbfsigma = 2"), self.query("--sigma", "2"))


if __name__ == "__main__":
    unittest.main()
