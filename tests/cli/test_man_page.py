"""The manual page: what --help says, and nothing that man(1) would complain about."""

import re
import shutil
import subprocess
import unittest

from support import Case


def words(text):
    return " ".join(text.split())


class ManPage(Case):
    def setUp(self):
        super().setUp()
        self.source = self.succeed("man-page").out.decode()
        # What is shown of it, but for fonts.
        self.text = re.sub(r"\\(-|e|:|&|f[BIR])", lambda m: {"-": "-", "e": "\\"}.get(m[1], ""), self.source)

    def help_of(self, *command):
        return self.succeed(*command, "--help").out.decode()

    def commands(self):
        return re.findall(r"^  ([a-z-]+) ", self.help_of().split("Subcommands:\n")[1], re.MULTILINE)

    def section(self, command):
        found = re.search(rf"^\.SS\npalpate {command} (.*?)(?=^\.S[SH])", self.text, re.MULTILINE | re.DOTALL)
        self.assertIsNotNone(found, command)
        return found[1]

    def test_has_every_command_with_its_arguments(self):
        commands = self.commands()
        self.assertGreater(len(commands), 10)
        for command in commands:
            usage = re.search(r"^Usage: palpate [a-z-]+ (.*)$", self.help_of(command), re.MULTILINE)[1]
            self.assertEqual(self.section(command).split("\n")[0], usage)

    def test_has_every_option_with_what_help_says_of_it(self):
        for command in self.commands():
            section = words(self.section(command))
            # An option and its description, be they on one line or two.
            options = re.findall(r"^  (-\S.*(?:\n {20,}\S.*)*)", self.help_of(command), re.MULTILINE)
            self.assertGreater(len(options), 0)
            for option in map(words, options):
                if not option.startswith("-h,--help"):
                    self.assertIn(option, section)

    def test_leaves_out_what_help_leaves_out(self):
        self.assertNotIn("palpate columns", self.text)
        self.assertNotIn("palpate man-page [", self.text)

    @unittest.skipUnless(shutil.which("man"), "no man here")
    def test_man_takes_it(self):
        self.write("palpate.1", self.source)
        result = subprocess.run(["man", "--warnings", "-E", "UTF-8", "-l", self.path("palpate.1")], capture_output=True,
                                env={"PATH": "/usr/bin:/bin", "MANWIDTH": "80"})
        self.assertEqual(result.stderr, b"")
        self.assertIn(b"SEE ALSO", result.stdout)


if __name__ == "__main__":
    unittest.main()
