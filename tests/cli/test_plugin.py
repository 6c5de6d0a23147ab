"""palpate run --device plugin:PATH.so, and what it refuses."""

import json
import os
import signal
import subprocess
import time
import unittest

from support import PALPATE, Case, faults_but_late, ply, rows_of, wall_rows

PLUGINS = os.environ.get("PALPATE_PLUGINS", os.path.join(os.path.dirname(__file__), "../../build/release/plugins"))


def plugin(name):
    return "plugin:" + os.path.join(PLUGINS, name + ".so")


class Plugin(Case):
    def setUp(self):
        super().setUp()
        self.wall = self.write("wall.ply", ply(wall_rows()))
        self.common = (self.wall, "--no-gateway", "--no-index-file", "--tool", "0.02,0.02,0.02")

    def test_a_wall_is_felt_through_the_example(self):
        """It swings from 1 cm above the wall to 7 cm: a ball of 2 cm touches it once every two seconds."""
        summary = self.succeed("run", *self.common, "--device", plugin("pendulum") + ":0.01", "--seconds", "3", "--json", "-q").json
        self.assertGreater(summary["contacts_max"], 0)
        self.assertGreater(summary["force_max"], 0.1)
        self.assertEqual(faults_but_late(summary), [])

    def test_a_configuration_names_one(self):
        config = self.write("run.toml", f'device = "{plugin("pendulum")}:0.5"\n'.encode())
        summary = self.succeed("run", *self.common, "--config", config, "--seconds", "0.3", "--json", "-q").json
        self.assertEqual(summary["contacts_max"], 0)

    def test_what_is_no_device_is_refused_with_one_line(self):
        for text, words in {
            "plugin:/nowhere/arm.so": "/nowhere/arm.so: there is no such file",
            plugin("bad_no_symbol"): "is not a device plug-in",
            plugin("bad_wrong_version"): "recompile it",
            plugin("bad_no_read"): "lacks a required function",
            plugin("bad_nan_force"): "force_max must be positive",
            plugin("bad_no_device"): "no arm is plugged in; plug it in",
            plugin("pendulum") + ":high": "'high' is no height",
            plugin("exported_plugin") + ":null": "its factory returned no device",
            "no_such:x": "palpate_device_no_such.so",
        }.items():
            with self.subTest(device=text):
                self.refuse(1, words, "run", *self.common, "--device", text, "--seconds", "1")

    def run_until_the_motors_pull(self):
        motors = self.write("motors", b"")
        process = subprocess.Popen([PALPATE, "run", *self.common, "--device", plugin("logged_motors") + ":" + motors, "--json", "-q"],
                                   cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(lambda: process.poll() is None and process.kill())
        for _ in range(600):
            time.sleep(0.05)
            if self.read("motors") == b"1":
                break
        self.assertEqual(self.read("motors"), b"1", "no force")
        return process

    def test_a_crash_stops_the_motors(self):
        """Killed, it stops nothing: that is left to the device's own watchdog."""
        for deadly, left in {signal.SIGSEGV: b"0", signal.SIGBUS: b"0", signal.SIGFPE: b"0", signal.SIGILL: b"0", signal.SIGABRT: b"0",
                             signal.SIGKILL: b"1"}.items():
            with self.subTest(signal=deadly):
                process = self.run_until_the_motors_pull()
                process.send_signal(deadly)
                process.communicate(timeout=60)
                self.assertEqual(process.returncode, -deadly)
                self.assertEqual(self.read("motors"), left)

    def ask(self, driver):
        with open(os.path.join(self.folder, "motors"), "r+b") as file:
            file.seek(1)
            file.write(driver)

    def test_a_crash_during_a_write_stops_the_motors(self):
        """The write ends after the stop."""
        process = self.run_until_the_motors_pull()
        self.ask(b"s")
        time.sleep(0.05)
        process.send_signal(signal.SIGABRT)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, -signal.SIGABRT)
        self.assertEqual(self.read("motors"), b"0s")

    def test_a_driver_without_stack_left_has_its_motors_stopped(self):
        process = self.run_until_the_motors_pull()
        self.ask(b"!")
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, -signal.SIGSEGV)
        self.assertEqual(self.read("motors"), b"0!")

    def test_a_driver_that_hangs_is_shown_and_left_behind(self):
        process = subprocess.Popen([PALPATE, "run", *self.common, "--device", plugin("bad_hangs"), "--record", "run.csv", "--json"],
                                   cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(lambda: process.poll() is None and process.kill())
        while b"no force: stalled" not in (line := process.stderr.readline()):
            self.assertTrue(line, "it never said so")
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, err)
        self.assertIn(b"does not return; its motors were told to stop", err)
        summary = json.loads(out)
        self.assertIn("stalled", summary["faults"])
        self.assertEqual(summary["state"], "stopped")
        self.assertGreaterEqual(len(rows_of(self.read("run.csv"))), summary["ticks"])

    def test_a_driver_that_hangs_when_it_is_closed_is_left_behind(self):
        self.refuse(1, "does not return; its motors were told to stop", "run", *self.common, "--device", plugin("bad_close_hangs"),
                    "--seconds", "0.3", "-q")

    def test_a_signal_ends_a_driver_that_hangs_when_it_is_opened(self):
        process = subprocess.Popen([PALPATE, "run", *self.common, "--device", plugin("bad_open_hangs"), "--json"],
                                   cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(lambda: process.poll() is None and process.kill())
        time.sleep(1.0)
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, -signal.SIGINT, err)
        self.assertEqual(err.splitlines()[-1], b"palpate: ended by a signal before the run began; a device that was being opened is not closed")

    def test_no_hand_has_a_force_while_the_driver_of_another_hangs(self):
        motors = self.write("motors", b"")
        left = self.write("left.toml", f'device = "{plugin("bad_enable_hangs")}"\n'.encode())
        process = subprocess.Popen([PALPATE, "run", *self.common, "--device", plugin("logged_motors") + ":" + motors, "--hands", "left=" + left],
                                   cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(lambda: process.poll() is None and process.kill())
        for _ in range(60):  # alone, it has one after two seconds
            time.sleep(0.05)
            self.assertNotEqual(self.read("motors"), b"1")
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, -signal.SIGINT, err)
        self.assertNotEqual(self.read("motors"), b"1")

    def test_what_is_no_name_is_bad_usage(self):
        self.refuse(2, "--device", "run", *self.common, "--device", "arm.so", "--seconds", "1")


if __name__ == "__main__":
    unittest.main()
