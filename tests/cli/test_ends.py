"""How a run ends, or is held up, while a hand leans on a wall: the force falls to zero and never rises. Times are read from the
program's own record and are wide: the machine is shared."""

import json
import os
import resource
import signal
import time
import unittest

from support import SANITIZED, path_csv, rows_of, stop, table_of
from test_gateway import Gateway
from test_run import RATE, Live

FALLING, STOPPED = "falling", "stopped"
ENDED, LATE_TICK = "ended", "late-tick"
LEANS = 3.0  # N, at least


def lean(seconds=60.0):
    """A hand that waits in front of the wall at z = 0 until the force is on, and leans on it from then on."""
    rows = [(0.0, 0.0, 0.0, 0.03), (1.2, 0.0, 0.0, 0.03), (1.7, 0.0, 0.0, 0.001), (seconds, 0.0, 0.0, 0.001)]
    return path_csv(rows)


def force(row):
    return sum(float(row[f"sf{axis}"]) ** 2 for axis in "xyz") ** 0.5


class Falls:
    def assert_falls(self, rows, begin, within):
        """From row `begin` on: never more force than before, and none after `within` seconds or two ticks more."""
        last = force(rows[begin - 1])
        start = float(rows[begin]["t"])
        if os.environ.get("PALPATE_PRINT"):
            gone = next((float(row["t"]) for row in rows[begin:] if force(row) == 0.0), float("nan"))
            print(f"{self._testMethodName}: {last:.2f} N before, {max(map(force, rows[begin:])):.2f} N at most from then on, "
                  f"none after {1e3 * (gone - start):.0f} ms")
        for row, after in zip(rows[begin:], rows[begin + 1:] + rows[-1:]):
            self.assertLessEqual(force(row), last + 1e-12, row)
            if row["state"] not in (FALLING, STOPPED):
                break
            last = force(row)
            if float(row["t"]) >= start + within:
                self.assertEqual(last, 0.0, (start, row))

    def first(self, rows, state, begin=0):
        return next(k for k in range(begin, len(rows)) if rows[k]["state"] == state)

    def last_fall(self, rows):
        return 1 + max(k for k in range(len(rows)) if rows[k]["state"] not in (FALLING, STOPPED))


class Ends(Falls, Live):
    def setUp(self):
        super().setUp()
        self.write("hand.csv", lean())

    def arguments(self, *more, scene="wall.ply"):
        return super().arguments("--hand", "0.1,30,5000", "--record", "run.csv", *more, scene=scene)

    def until_it_leans(self, process, since=0):
        for _ in range(600):
            self.assertIsNone(process.poll(), "it has ended")
            time.sleep(0.1)
            if os.path.exists(self.path("run.csv")) and b"\n" in self.read("run.csv"):
                rows = self.rows()
                if len(rows) > since + 50 and all(force(row) > LEANS for row in rows[-20:]):
                    return rows
        self.fail("no force")

    def end(self, process, code=0):
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, code, err)
        return out, err

    def test_every_signal_that_ends_it_lets_the_force_fall(self):
        for sign in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
            with self.subTest(sign=sign):
                if os.path.exists(self.path("run.csv")):
                    os.remove(self.path("run.csv"))
                process = self.start("--json")
                self.until_it_leans(process)
                process.send_signal(sign)
                process.send_signal(sign)  # who is in a hurry asks twice
                self.end(process)
                rows = self.rows()
                begin = self.last_fall(rows)
                self.assertIn(rows[begin]["fault"], (ENDED, LATE_TICK))  # a slow machine may be late just then
                self.assert_falls(rows, begin, 0.1)
                self.assertEqual(force(rows[-1]), 0.0)

    def stopped_for(self, gap):
        """The rows of a run that stood still so long, and which is the first after it."""
        if os.path.exists(self.path("run.csv")):
            os.remove(self.path("run.csv"))
        process = self.start("--json")
        before = len(self.until_it_leans(process))
        stop(process)
        time.sleep(gap)
        process.send_signal(signal.SIGCONT)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        self.end(process)
        rows = self.rows()
        times = [float(row["t"]) for row in rows]
        return rows, max(range(before, len(rows)), key=lambda k: times[k] - times[k - 1])

    def test_who_was_stopped_goes_through_the_gate(self):
        for gap in (0.06, 0.3, 1.0):
            with self.subTest(gap=gap):
                for _ in range(3):  # a slow machine may be late just before, too
                    rows, k = self.stopped_for(gap)
                    if rows[k - 1]["state"] not in (FALLING, STOPPED):
                        break
                times = [float(row["t"]) for row in rows]
                self.assertGreaterEqual(times[k] - times[k - 1], 0.9 * gap)
                self.assertEqual(rows[k]["state"], FALLING)
                self.assertEqual(rows[k]["fault"], LATE_TICK)
                self.assert_falls(rows, k, 0.03)

    def test_a_terminal_that_is_held_holds_up_nothing(self):
        master, process = self.on_a_terminal()
        self.addCleanup(os.close, master)
        self.until_it_leans(process)
        os.write(master, b"\x13")  # Ctrl-S
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        process.wait(timeout=30)
        process.stdout.close()
        self.assertEqual(process.returncode, 0)
        rows = self.rows()
        self.assert_falls(rows, self.first(rows, FALLING), 0.1)

    def test_a_pipe_that_nobody_reads_holds_up_nothing(self):
        reader, writer = os.pipe()
        os.set_blocking(writer, False)
        try:
            while True:
                os.write(writer, b"x" * 4096)
        except BlockingIOError:
            pass
        os.set_blocking(writer, True)
        process = self.start("--json", stderr=writer)
        os.close(writer)
        self.addCleanup(os.close, reader)
        self.until_it_leans(process)
        process.send_signal(signal.SIGUSR1)  # which it would like to tell
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        process.wait(timeout=30)
        process.stdout.close()
        rows = self.rows()
        self.assert_falls(rows, self.first(rows, FALLING), 0.03)

    def test_a_reader_that_has_gone_is_told_at_the_end(self):
        process = self.start("--json")
        self.until_it_leans(process)
        process.stdout.close()
        process.send_signal(signal.SIGPIPE)
        time.sleep(0.3)
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGINT)
        err = process.stderr.read()
        process.stderr.close()
        self.assertEqual(process.wait(timeout=30), 1)
        self.assertIn(b"standard output", err.splitlines()[-1])
        rows = self.rows()
        self.assert_falls(rows, self.first(rows, FALLING), 0.1)

    def test_streams_that_are_closed_are_no_files_of_its_own(self):
        process = self.start("--json", stdin=None, stdout=None, stderr=None, preexec_fn=lambda: os.closerange(0, 3))
        self.until_it_leans(process)
        process.send_signal(signal.SIGINT)
        process.wait(timeout=30)
        self.assertTrue(table_of(self.read("run.csv")).startswith("t,"))
        self.assertNotIn(b"palpate", self.read("run.csv"))

    def test_an_index_file_may_be_cut_and_written_over(self):
        process = self.start("--json")
        before = len(self.until_it_leans(process))
        index = self.path("wall.ply.palpate")
        size = os.path.getsize(index)
        with open(index, "r+b") as file:
            file.write(b"\xff" * size)
        os.truncate(index, 0)
        rows = self.until_it_leans(process, since=before + int(RATE) // 2)
        process.send_signal(signal.SIGINT)
        self.end(process)
        self.assertEqual({row["fault"] for row in rows[before:]} - {LATE_TICK}, {"none"})

    def test_a_name_that_is_not_utf_8_is_a_name(self):
        name = b"wall\xff.ply"
        os.rename(self.path("wall.ply").encode(), os.path.join(os.fsencode(self.folder), name))
        process = self.start("--json", "--port", "0", scene=os.fsdecode(name))
        self.until_it_leans(process)
        process.send_signal(signal.SIGINT)
        self.end(process)


class EndsWithAGateway(Falls, Gateway):
    def setUp(self):
        super().setUp()
        self.write("hand.csv", lean())
        self.leaning = ("--tool", "0.01,0.01,0.01", "--hand", "0.1,30,5000", "--record", "run.csv")

    def until_it_leans(self):
        self.until(lambda: os.path.exists(os.path.join(self.folder, "run.csv")) and max(self.forces(), default=0) > LEANS)

    def forces(self):
        return [force(row) for row in rows_of(self.read("run.csv"))]

    def until(self, done, pause=0.1):
        for _ in range(600):
            if done():
                return
            time.sleep(pause)
        self.fail("it does not come to that")

    def parameters(self, send, receive):
        send({"op": "call_service", "service": "/palpate/get_parameters", "id": "get"})
        while (answer := json.loads(receive()[1])).get("id") != "get":
            pass
        return json.loads(answer["values"]["message"])

    @unittest.skipIf(SANITIZED, "AddressSanitizer reserves all there is")
    def test_a_change_that_finds_no_memory_changes_nothing(self):
        self.start(*self.leaning)
        send, receive = self.socket()
        self.until_it_leans()
        with open(f"/proc/{self.process.pid}/statm") as pages:
            taken = int(pages.read().split()[0]) * resource.getpagesize()
        before = resource.prlimit(self.process.pid, resource.RLIMIT_AS, (taken, resource.RLIM_INFINITY))
        for _ in range(3):  # long ones are decoded on a thread that has no memory of its own yet
            send({"op": "publish", "topic": "/nobody", "msg": {"x": list(range(4000))}})
        large = json.dumps({"tool": [{"semi_axes": [0.01, 0.01, 0.01]}] * 64}, separators=(",", ":"))  # decoded at once: short
        change = {"op": "call_service", "service": "/palpate/set_parameters", "args": {"json": large}}
        send(change)
        self.until(lambda: "not enough memory" in self.parameters(send, receive)["message"])
        begin = len(self.forces())
        self.until(lambda: len(self.forces()) > begin + 50)
        self.assertGreater(min(self.forces()[begin:]), LEANS, "what was felt is felt on")
        resource.prlimit(self.process.pid, resource.RLIMIT_AS, before)
        send(change)
        self.until(lambda: self.parameters(send, receive)["message"] == "")
        self.end()

    def test_what_is_being_made_ready_holds_up_no_end(self):
        """A million Gaussians are filtered and indexed anew while it is told to end."""
        self.succeed("make-scene", "plane", "--out", "wall.ply", "--spacing", "0.0004")
        self.start(*self.leaning)
        send, receive = self.socket()
        self.until_it_leans()
        send({"op": "call_service", "service": "/palpate/set_parameters", "args": {"json": json.dumps({"filter": {"opacity_min": 0.7}})}})
        self.until(lambda: self.parameters(send, receive)["busy"], pause=0.0)
        self.end()
        rows = rows_of(self.read("run.csv"))
        self.assert_falls(rows, self.last_fall(rows), 0.1)
        self.assertEqual(force(rows[-1]), 0.0)

    def test_a_disk_that_is_full_lets_the_force_fall(self):
        """The record is what is full: the force is what clients are told."""
        self.start(*self.leaning, preexec_fn=lambda: signal.signal(signal.SIGXFSZ, signal.SIG_IGN))
        send, receive = self.socket()
        send({"op": "subscribe", "topic": "/palpate/spatial/servo_cf"})
        self.until_it_leans()
        size = os.path.getsize(self.path("run.csv"))
        resource.prlimit(self.process.pid, resource.RLIMIT_FSIZE, (size + 100_000, resource.RLIM_INFINITY))
        told = []
        try:
            while True:
                message = json.loads(receive()[1])["msg"]
                stamp = message["header"]["stamp"]
                told.append((stamp["secs"] + 1e-9 * stamp["nsecs"], abs(message["wrench"]["force"]["z"])))
        except (OSError, ValueError):  # it has ended
            pass
        err = self.process.communicate(timeout=60)[1]
        self.assertEqual(self.process.returncode, 1, err)
        self.assertIn(b"run.csv", err.splitlines()[-1])
        before = max(k for k, (_, force) in enumerate(told) if force > LEANS)
        self.assertEqual(told[-1][1], 0.0)
        gone = next(t for t, force in told[before:] if force == 0.0) - told[before][0]
        if os.environ.get("PALPATE_PRINT"):
            print(f"{self._testMethodName}: {told[before][1]:.2f} N before, none after {1e3 * gone:.0f} ms")
        self.assertEqual(sorted((force for _, force in told[before:]), reverse=True), [force for _, force in told[before:]])
        self.assertLess(gone, 0.3)


if __name__ == "__main__":
    unittest.main()
