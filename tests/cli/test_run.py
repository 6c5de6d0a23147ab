"""palpate run: the live loop as a black box. Nothing about how long a tick takes is asserted: the machine is shared."""

import json
import os
import pty
import random
import select
import signal
import subprocess
import time
import tomllib
import unittest
from concurrent.futures import ThreadPoolExecutor

from support import LIVE_HEADER, PALPATE, RUN_HEADER, SANITIZED, Case, columns_of, faults_but_late, head_of, path_csv, ply, rows_of, stood_still, table_of, wall_rows

KEYS = ["ticks", "rate_hz", "overruns", "tick_us", "cpu_us", "age_us", "late_us", "contact_ticks", "contacts_max", "force_max",
        "port_energy", "margin_min", "state", "faults", "lost", "made"]
STUCK_DISK = os.environ.get("STUCK_DISK_LIBRARY")
RATE = "200" if SANITIZED else "1000"


def press_path(depth=0.004, seconds=6.0):
    """A hand that waits in front of the wall at z = 0, and presses once a second from the first second on."""
    rows = []
    for k in range(int(seconds * 100) + 1):
        t = k / 100
        phase = (t - 1.0) % 1.0 if t > 1.0 else 0.0
        down = min(phase / 0.3, 1.0) * min((1.0 - phase) / 0.3, 1.0) if t > 1.0 else 0.0
        rows.append((t, 0.0, 0.0, 0.05 - (0.05 - 0.01 + depth) * down))
    return path_csv(rows)


def deep_press(depth, speed=0.1):
    """A hand that presses `depth` into a ball of 15 cm with a tool of 4 cm, both upright, and comes back."""
    above, first, there = 0.22, 0.5, 0.03 + depth
    times = [0.0, first, first + there / speed, first + there / speed + 0.3, first + 2 * there / speed + 0.3, first + 2 * there / speed + 0.8]
    return path_csv([(t, 0.0, 0.0, z) for t, z in zip(times, [above, above, above - there, above - there, above, above])]), times[-1]


class Live(Case):
    def setUp(self):
        super().setUp()
        self.write("wall.ply", ply(wall_rows()))
        self.write("hand.csv", press_path())

    def arguments(self, *more, scene="wall.ply"):
        return ["run", scene, "--trajectory", "hand.csv", "--tool", "0.01,0.01,0.01", "--rate", RATE, *more]

    def together(self, *runs):
        """The summaries of several runs at the same time: each waits for its next tick most of the time."""
        with ThreadPoolExecutor(3) as pool:
            return list(pool.map(lambda more: self.succeed(*self.arguments(*more, "--json")).json, runs))

    def calm(self, *arguments):
        """The summary of a run on a machine that neither stood still meanwhile nor was late again and again, which is a fault,
        and rightly; of the fifth run whatever the machine did."""
        for _ in range(5):
            document = self.succeed(*arguments, "--json").json
            if stood_still(document) < 10_000 and "late-tick" not in document["faults"]:
                break
        return document

    def start(self, *more, scene="wall.ply", **options):
        given = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
        process = subprocess.Popen([PALPATE, *self.arguments(*more, scene=scene)], cwd=self.folder, **given)
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process

    def on_a_terminal(self, *more, **options):
        """A run whose keys and status line are those of a new terminal. Returns that and the process."""
        master, slave = pty.openpty()
        process = subprocess.Popen([PALPATE, *self.arguments("--json", *more)], cwd=self.folder, stdin=slave,
                                   stdout=subprocess.PIPE, stderr=slave, start_new_session=True,
                                   preexec_fn=lambda: __import__("fcntl").ioctl(0, 0x540E, 0), **options)  # TIOCSCTTY
        self.addCleanup(lambda: process.poll() is None and process.kill())
        os.close(slave)
        return master, process

    def rows(self, name="run.csv"):
        return rows_of(self.read(name))


class ManyParts(Live):
    @unittest.skipIf(SANITIZED, "which takes memory of its own")
    def test_the_memory_of_a_tool_is_bounded(self):
        parts = [f"[[ellipsoid]]\nname = \"{k}\"\nsemi_axes = [0.004, 0.004, 0.004]\nposition = [{k % 16 * 0.01}, {k // 16 * 0.01}, 0.0]\n"
                 for k in range(256)]
        self.write("many.toml", "".join(parts))
        for contacts in ("inline", "worker"):
            process = subprocess.Popen(
                [PALPATE, "run", "wall.ply", "--trajectory", "hand.csv", "--tool", "many.toml", "--contacts", contacts,
                 "--seconds", "0.5", "--no-gateway", "-q"], cwd=self.folder, stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            self.addCleanup(process.stderr.close)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            self.assertEqual(process.returncode, 0, process.stderr.read())
            self.assertLess(usage.ru_maxrss, 1_000_000, contacts)  # KiB


class Summary(Live):
    def test_json_is_the_only_thing_on_stdout(self):
        document = self.calm(*self.arguments("--seconds", "3"))
        self.assertEqual(list(document), KEYS)
        self.assertEqual(list(document["tick_us"]), ["p50", "p99", "p999", "max"])
        times = list(document["tick_us"].values())
        self.assertEqual(times, sorted(times))
        self.assertGreater(document["ticks"], 100)
        self.assertGreater(document["contact_ticks"], 10)
        self.assertGreater(document["contacts_max"], 0)
        self.assertEqual(document["state"], "active")
        self.assertEqual(document["faults"], [])
        self.assertLess(document["port_energy"], 1e-3)

    def test_every_beat_is_a_tick_or_an_overrun(self):
        document = self.succeed(*self.arguments("--seconds", "2", "--json")).json
        beats = document["ticks"] + document["overruns"]
        self.assertGreaterEqual(beats, 0.8 * 2 * float(RATE))
        self.assertLessEqual(beats, 1.3 * 2 * float(RATE) + 100)

    def test_the_force_is_the_stiffness_times_the_depth(self):
        # A hand so firm that it is where it wants to be.
        soft, firm = self.together(*(("--seconds", "3", "--stiffness", stiffness, "--hand", "0.1,30,20000")
                                     for stiffness in ("100", "400")))
        self.assertGreater(soft["force_max"], 0.2)
        self.assertAlmostEqual(firm["force_max"] / soft["force_max"], 4.0, delta=0.4)

    def test_a_hand_that_presses_far_past_the_largest_force_is_no_fault(self):
        self.succeed("make-scene", "sphere", "--out", "ball.ply", "-q")
        for depth in (0.12, 0.16):
            with self.subTest(depth=depth):
                path, seconds = deep_press(depth)
                self.write("deep.csv", path)
                document = self.calm("run", "ball.ply", "--trajectory", "deep.csv", "--no-gateway", "--seconds", str(seconds))
                self.assertEqual((document["state"], document["faults"]), ("active", []))
                self.assertAlmostEqual(document["force_max"], 12.0, delta=0.01)  # all that the device has

    def test_the_builtin_scene_is_explored_without_any_file(self):
        document = self.calm("run", "--seconds", "5", "--rate", RATE)
        self.assertEqual(document["state"], "active")
        self.assertGreater(document["contact_ticks"], 0)
        self.assertEqual(self.files(), ["hand.csv", "wall.ply"])

    def test_text_says_what_was_felt(self):
        result = self.succeed(*self.arguments("--seconds", "2"))
        for word in ("ticks", "overruns", "p99.9", "in contact", "net energy"):
            self.assertIn(word, result.out.decode())

    def test_quiet_says_nothing(self):
        result = self.succeed(*self.arguments("--seconds", "1", "-q"))
        self.assertEqual((result.out, result.err), (b"", b""))

    def test_a_config_file_is_heard(self):
        self.write("live.toml", f'seconds = 1.0\nrate = {RATE}\nprofile = "falcon"\nmodel = "field"\n')
        result = self.succeed("run", "wall.ply", "--trajectory", "hand.csv", "--config", "live.toml", "--json")
        self.assertLess(result.json["ticks"], 2 * float(RATE))
        self.assertIn(b"falcon", result.err)
        self.assertIn(b"field", result.err)


class Contacts(Live):
    def test_a_late_worker_feels_the_same_as_the_loop(self):
        inline = self.calm(*self.arguments("--seconds", "3", "--contacts", "inline"))
        for _ in range(5):  # a thread that the machine leaves waiting is late indeed, and that faults
            worker = self.calm(*self.arguments("--seconds", "3", "--contacts", "worker", "--worker-delay", "0.05"))
            if not {"late-tick", "late-contacts"}.intersection(worker["faults"]):
                break
        self.assertEqual((inline["faults"], worker["faults"]), ([], []))
        self.assertAlmostEqual(worker["force_max"], inline["force_max"], delta=0.15 * inline["force_max"])

    def test_a_worker_that_stalls_takes_the_force_away(self):
        document = self.calm(*self.arguments("--seconds", "3", "--contacts", "worker", "--worker-delay", "0.5"))
        self.assertEqual(document["faults"], ["late-contacts"])


class Recording(Live):
    def record(self, *more):
        return self.succeed(*self.arguments("--seconds", "3", "--record", "run.csv", *more))

    def test_says_how_it_was_made(self):
        document = self.record("--stiffness", "432", "--token", "0123456789abcdef-secret", "--json").json
        head = tomllib.loads(head_of(self.read("run.csv")))
        made, settings = head["made"], head["settings"]
        self.assertEqual((made["command"], made["scene"], made["device"]), ("run", "wall.ply", "omega (simulated)"))
        self.assertRegex(made["scene-checksum"], r"^xxh3-16MiB:[0-9a-f]{16}$")
        self.assertEqual((settings["stiffness"], settings["profile"], settings["rate"]), (432, "omega", float(RATE)))
        self.assertNotIn(b"secret", self.read("run.csv"))
        told = document["made"]
        self.assertEqual((told.pop("settings"), told["scene_checksum"]), (settings, made["scene-checksum"]))
        self.succeed("replay", "--from", "run.csv", "--out", "again.csv", "-q")
        again, rows = columns_of(self.read("again.csv")), self.rows()
        self.assertEqual([row["z"] for row in rows], again["z"])
        self.assertGreater(max(map(int, again["colliding"])), 0)
        self.assertEqual({row["state"] for row in rows} - {"waiting", "rising", "active", "falling", "stopped"}, set())

    def test_has_every_tick_in_the_run_format(self):
        document = self.record("--json").json
        self.assertEqual(table_of(self.read("run.csv")).split("\n", 1)[0], RUN_HEADER + LIVE_HEADER)
        rows = self.rows("run.csv")
        self.assertGreaterEqual(len(rows), document["ticks"])  # and those in which it came to its end
        self.assertLess(len(rows) - document["ticks"], float(RATE))
        times = [float(row["t"]) for row in rows]
        self.assertEqual(times, sorted(set(times)))
        self.assertEqual(max(int(row["colliding"]) for row in rows), document["contacts_max"])
        sent = max(sum(float(row[f"sf{axis}"]) ** 2 for axis in "xyz") ** 0.5 for row in rows)
        self.assertAlmostEqual(sent, document["force_max"], places=9)
        self.assertEqual(float(rows[-1]["sfz"]), 0.0)  # it ends with no force

    def test_report_shows_it(self):
        self.record()
        self.succeed("report", "run.csv", "--out", "report.html")
        self.assertIn(b"run.csv", self.read("report.html"))

    def test_an_existing_file_is_not_replaced(self):
        self.write("run.csv", "precious")
        self.refuse(1, "run.csv", *self.arguments("--seconds", "1", "--record", "run.csv"))
        self.assertEqual(self.read("run.csv"), b"precious")

    def test_what_a_killed_run_leaves_is_read(self):
        seeded = random.Random(20)
        for k in range(20 if os.environ.get("PALPATE_LONG") else 4):
            name = f"killed{k}.csv"
            process = self.start("--record", name)
            while not os.path.exists(self.path(name)):
                time.sleep(0.01)
            time.sleep(0.3 + seeded.random())
            before = time.monotonic()
            process.kill()
            process.wait()
            process.stdout.close()
            process.stderr.close()
            self.succeed("report", name, "--out", f"{name}.html")
            self.assertGreater(self.read(name).count(b"\n"), 0.2 * float(RATE) * 0.3, before)

    def test_a_disk_that_is_full_ends_the_run_with_the_reason(self):
        import resource

        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))

        process = self.start("--record", "run.csv", preexec_fn=limit)
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, err)
        self.assertIn(b"run.csv", err.splitlines()[-1])
        self.assertIn(b"recorder", err)
        rows = self.rows("run.csv")  # whole to the last line
        self.assertGreater(len(rows), 100)
        self.succeed("report", "run.csv", "--out", "report.html")

    @unittest.skipUnless(STUCK_DISK, "not with a sanitizer, or not started by ctest")
    def test_ticks_that_a_recording_lacks_are_said(self):
        env = {**os.environ, "LD_PRELOAD": STUCK_DISK}
        runs = [subprocess.Popen([PALPATE, "run", "--no-gateway", "--rate", "10000", "--seconds", "9", "--record", self.path(name), *option],
                                 stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=env)
                for name, option in (("a.csv", ["--json"]), ("b.csv", ["--quiet"]))]
        (out, err), (none, quiet) = (run.communicate(timeout=60) for run in runs)
        self.assertEqual([run.returncode for run in runs], [0, 0], err + quiet)
        lost = json.loads(out)["lost"]
        self.assertGreater(lost, 0)
        self.assertIn(b"a.csv lacks %d ticks: the disk is too slow" % lost, err)
        self.assertEqual(none, b"")
        self.assertRegex(quiet, rb"^palpate: warning: .*b.csv lacks \d+ ticks: the disk is too slow\n$")

    def test_a_recording_that_is_removed_ends_the_run_and_one_that_is_moved_is_said(self):
        for name, change, words in (("removed.csv", os.remove, b"removed.csv: was removed while it was being written"),
                                    ("moved.csv", lambda path: os.rename(path, path + ".old"), b"moved.csv: was moved while it was being written")):
            path = self.path(name)
            process = self.start("--record", name, "--seconds", "3")
            while not os.path.exists(path) or os.path.getsize(path) < 20_000:
                time.sleep(0.01)
            change(path)
            out, err = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 1, err)
            self.assertIn(words, err.splitlines()[-1])
            self.assertNotIn(b"wrote", out)
        self.succeed("report", "moved.csv.old", "--out", "moved.html")


class Hands(Live):
    def test_an_interrupt_ends_it_with_a_summary(self):
        for sign in (signal.SIGINT, signal.SIGTERM):
            process = self.start("--json")
            time.sleep(1.0)
            process.send_signal(sign)
            out, err = process.communicate(timeout=30)
            self.assertEqual(process.returncode, 0, err)
            self.assertEqual(list(json.loads(out)), KEYS)

    def test_a_signal_is_an_emergency_stop(self):
        process = self.start("--json", "--seconds", "3", "--record", "run.csv")
        while not os.path.exists(self.path("run.csv")):
            time.sleep(0.01)
        time.sleep(1.0)
        process.send_signal(signal.SIGUSR1)
        out, err = process.communicate(timeout=60)
        document = json.loads(out)
        self.assertEqual(faults_but_late(document), ["emergency-stop"])
        self.assertEqual(document["state"], "stopped")
        self.assertIn(b"emergency-stop", err)
        rows = self.rows("run.csv")
        self.assertEqual({float(row["sfz"]) for row in rows[-200:]}, {0.0})

    def test_one_file_for_both_streams_keeps_every_line(self):
        for mode in ("wb", "ab"):  # > log 2>&1, and >> log 2>&1
            with self.subTest(mode=mode):
                with open(self.path("log"), mode) as log:
                    log.write(b"before\n")
                    log.flush()
                    process = self.start("--seconds", "2", "--record", f"{mode}.csv", "--no-gateway", stdout=log, stderr=log)
                while not os.path.exists(self.path(f"{mode}.csv")):
                    time.sleep(0.01)
                time.sleep(0.5)
                process.send_signal(signal.SIGUSR1)
                self.assertEqual(process.wait(timeout=60), 0)
                text = self.read("log").decode()
                os.remove(self.path("log"))
                self.assertTrue(text.startswith("before\n"), text)
                self.assertRegex(text, r"(?m)^palpate: \d+\.\d+ s: no force: emergency-stop: .+$")
                self.assertRegex(text, rf"(?m)^wrote {mode}\.csv: ")
                self.assertNotIn("\0", text)

    def test_the_status_line_does_not_wrap(self):
        master, process = self.on_a_terminal("--seconds", "1", "--no-gateway")
        drawn = b""
        try:
            while piece := os.read(master, 65536):
                drawn += piece
        except OSError:  # its end of the terminal is closed
            pass
        process.communicate(timeout=30)
        os.close(master)
        lines = [line for line in drawn.split(b"\r\x1b[K") if b" N/m" in line]
        self.assertGreater(len(lines), 2)
        for line in lines:
            self.assertTrue(line.startswith(b"\x1b[?7l") and b"\x1b[?7h" in line, line)

    def test_keys_are_heard_on_a_terminal(self):
        master, process = self.on_a_terminal()
        seen = b""

        def until(word, seconds=30):
            nonlocal seen
            end = time.monotonic() + seconds
            while word not in seen:
                self.assertLess(time.monotonic(), end, (word, seen[-500:]))
                if select.select([master], [], [], 0.1)[0]:
                    seen += os.read(master, 65536)
            seen = seen[seen.rindex(word) + len(word):]

        until(b"active")
        os.write(master, b"m")
        until(b"no force: changing")
        until(b"field")
        os.write(master, b"+")
        until(b"625 N/m")
        os.write(master, b" ")
        until(b"stopped (paused)")
        os.write(master, b" ")
        until(b"active")
        os.write(master, b"e")
        until(b"stopped (emergency-stop)")
        os.write(master, b"q")
        out = process.communicate(timeout=30)[0]
        os.close(master)
        document = json.loads(out)
        self.assertEqual(process.returncode, 0)
        self.assertEqual(faults_but_late(document), ["changing", "paused", "emergency-stop"])


@unittest.skipUnless(os.environ.get("SERVO_WATCH_LIBRARY"), "not with a sanitizer, or not started by ctest")
class ServoThread(Live):
    """In the whole running program: no heap, no lock and no writing on the thread that a hand holds on to."""

    def watch(self, *more, process=None):
        counts = "watch" + "".join(more[:4])
        watched = {"LD_PRELOAD": os.environ["SERVO_WATCH_LIBRARY"], "SERVO_WATCH": self.path(counts)}
        run = process or (lambda env: self.succeed(*self.arguments("--seconds", "3", "--json", *more), env=env))
        run(watched)
        ticks, heap, locks, writes, others = map(int, self.read(counts).split())
        self.assertGreater(ticks, 500)
        self.assertGreater(others, 100)
        self.assertEqual((heap, locks, writes), (0, 0, 0), more)

    def test_takes_no_heap_no_lock_and_writes_nothing(self):
        modes = [("--model", model, "--contacts", contacts, "--record", f"{model}-{contacts}.csv")
                 for model in ("proxy", "field", "density") for contacts in ("inline", "worker", "hold")]
        with ThreadPoolExecutor(3) as pool:  # each waits for its next tick most of the time
            list(pool.map(lambda mode: self.watch(*mode), [*modes, ("--device", "playback")]))

    def test_nor_while_a_person_changes_everything(self):
        def run(env):
            master, process = self.on_a_terminal(env={**os.environ, **env})
            try:
                for key in b"m+-cmc em+ q":
                    time.sleep(0.2)
                    os.write(master, bytes([key]))
            finally:
                process.communicate(timeout=30)
                os.close(master)

        self.watch(process=run)


class Playback(Live):
    def test_plays_the_trajectory_once_and_ends(self):
        self.write("hand.csv", press_path(seconds=3.0))
        document = self.succeed(*self.arguments("--device", "playback", "--json")).json
        self.assertLess(document["ticks"], 3.5 * float(RATE))
        self.assertGreater(document["contact_ticks"], 0)

    def test_nothing_to_play_is_refused(self):
        self.refuse(1, "--trajectory", "run", "wall.ply", "--device", "playback")

    def test_a_scale_brings_the_hand_no_farther_than_the_tool(self):
        # The tool goes the same way; the hand a quarter of it, and feels a quarter of the force.
        for _ in range(5):  # a late tick takes the force away
            one, four = self.together(*(("--device", "playback", "--seconds", "3", "--workspace-scale", scale)
                                        for scale in ("1", "4")))
            if "late-tick" not in one["faults"] + four["faults"]:
                break
        self.assertAlmostEqual(one["force_max"] / four["force_max"], 4.0, delta=0.4)


class Refusals(Live):
    def test_bad_usage(self):
        for option, value in (("--rate", "0"), ("--rate", "20000"), ("--device", "phantom"), ("--profile", "phantom"),
                              ("--hand", "1,2"), ("--hand", "-1,2,3"), ("--contacts", "never"), ("--cpu", "-3"),
                              ("--workspace-scale", "0"), ("--seconds", "-1"), ("--model", "soft")):
            self.refuse(2, option, "run", "wall.ply", option, value)

    def test_bad_files(self):
        self.refuse(1, "missing.ply", "run", "missing.ply")
        self.refuse(1, "missing.csv", "run", "wall.ply", "--trajectory", "missing.csv")
        self.refuse(1, "nowhere", *self.arguments("--record", "nowhere/run.csv"))

    def test_a_scene_with_nothing_to_touch_and_no_path_is_refused(self):
        self.write("empty.ply", ply([]))
        result = self.run_palpate("run", "empty.ply", "--seconds", "1")
        self.assertEqual(result.code, 1)
        self.assertIn(b"empty.ply", result.err)


if __name__ == "__main__":
    unittest.main()
