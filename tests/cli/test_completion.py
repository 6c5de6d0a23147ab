"""Completion scripts: they parse, and they complete."""

import re
import shlex
import shutil
import subprocess
import unittest

from support import COMMANDS, Case


class Completion(Case):
    def script(self, shell):
        script = self.succeed("completion", shell).out.decode()
        self.write("palpate." + shell, script)
        return script

    def complete(self, *words):
        """What bash offers for the last of `words` after `palpate`."""
        self.script("bash")
        quoted = " ".join(shlex.quote(w) for w in ("palpate", *words))
        code = (f"source ./palpate.bash; COMP_WORDS=({quoted}); COMP_CWORD={len(words)}; _palpate; "
                'printf "%s\\n" "${COMPREPLY[@]}"')
        result = subprocess.run(["bash", "--norc", "-c", code], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return result.stdout.split()

    def options(self, command):
        text = self.succeed(command, "--help").out.decode()
        return set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", text.split("\n\n", 2)[-1])) - {"--"}

    def test_bash_takes_the_script(self):
        self.script("bash")
        self.assertEqual(subprocess.run(["bash", "-n", self.path("palpate.bash")]).returncode, 0)

    def test_bash_completes_commands(self):
        self.assertEqual(self.complete("que"), ["query"])
        self.assertEqual(self.complete("rep"), ["replay", "report", "reproduce"])
        self.assertEqual(self.complete("make-"), ["make-scene", "make-path"])
        self.assertLessEqual(set(COMMANDS), set(self.complete("")))
        self.assertEqual(self.complete("--ver"), ["--version"])
        self.assertEqual(self.complete("nothing-like-it"), [])

    def test_bash_completes_options_and_files(self):
        self.assertEqual(self.complete("query", "--op"), ["--opacity-min"])
        self.assertEqual(self.complete("replay", "a.ply", "--traj"), ["--trajectory"])
        self.write("scene.ply", "")
        self.assertEqual(self.complete("info", "scen"), ["scene.ply"])
        self.assertEqual(self.complete("info", "--pose"), [])

    def test_every_shell_knows_every_command_and_option(self):
        for shell in ("bash", "zsh", "fish"):
            script = self.script(shell)
            for command in COMMANDS:
                self.assertIn(command, script)
                for option in self.options(command):
                    name = option if shell != "fish" else "-l " + option[2:]
                    self.assertIn(name, script, (shell, command))

    def test_quotes_are_balanced(self):
        for shell in ("zsh", "fish"):
            for line in self.script(shell).splitlines():
                shlex.split(line, comments=True)  # raises where a quote is left open

    def test_other_shells_take_the_script_where_they_are(self):
        for shell in ("zsh", "fish"):
            if shutil.which(shell):
                self.script(shell)
                self.assertEqual(subprocess.run([shell, "-n", self.path("palpate." + shell)]).returncode, 0)

    def test_zsh_script_starts_as_autoload_needs(self):
        self.assertTrue(self.script("zsh").startswith("#compdef palpate\n"))


if __name__ == "__main__":
    unittest.main()
