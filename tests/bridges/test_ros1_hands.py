"""The node palpate_ros1 with several hands, each with a driver of its own, and the local model rendered by a driver in C++."""

import csv
import fcntl
import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import rospy
import rosservice
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from ros1_support import FREE, PRESSED, Driver, Ear, Master, end_by_name, free_port

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../cli"))
from support import ply, wall_rows  # noqa: E402

NODE = os.environ["PALPATE_ROS1"]
LOCAL_DRIVER = os.environ["PALPATE_ROS1_LOCAL_DRIVER"]
CLOCK_BACK = os.environ["PALPATE_CLOCK_BACK"]
RATE = 200  # of poses, for as many drivers as Python can drive. Unit: [Hz]
LOOP = 250  # of their hands: each tick sends wrenches, which one process in Python reads for all of them. Unit: [Hz]
SOFT = 60  # so soft that no delay of Python makes it softer. Unit: [N/m].
STIFF = 500
DEEP = 0.02 - PRESSED  # that a ball is pressed in. Unit: [m]
HEAD, PLANE = 9, 6  # numbers of a local model


def shown(line):
    """The force in a line of the driver's. Unit: [N]."""
    return float(re.search(r"shown (\S+) N", line)[1])


class Hands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        port = free_port()
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1", ROS_LOG_DIR=folder.name, ROS_HOME=folder.name)
        scene, flat, cls.said = (os.path.join(folder.name, name) for name in ("wall.ply", "flat.toml", "said"))
        with open(scene, "wb") as file:
            file.write(ply(wall_rows()))
        with open(flat, "w", encoding="utf-8") as file:
            file.write('device = "ros1:/wide,force_max=8,rate=20"\ntool = [0.1, 0.1, 0.02]\n'
                       f"rate = {LOOP}\n")
        cls.master = Master(port)
        cls.addClassCleanup(lambda: cls.master.kill())
        rospy.init_node("driver", disable_signals=True, disable_rosout=True)
        with open(cls.said, "wb") as said:
            cls.node = subprocess.Popen([NODE, "__name:=palpate", f"_scene:={scene}", "_no_index_file:=true", "_tool:=0.02,0.02,0.02",
                                         "_device:=/omni,force_max=8,rate=20", f"_stiffness:={SOFT}", f"_hands:=left,flat={flat},far",
                                         f"_rate:={LOOP}", f"_left/rate:={LOOP}", "_far/rate:=1000",
                                         f"_left/stiffness:={SOFT // 2}", "_left/device:=/left,force_max=8,rate=20",
                                         "_left/device_frame:=left_base", "_far/device:=/far,force_max=8,rate=500", f"_far/stiffness:={STIFF}"], stdin=subprocess.DEVNULL, stdout=said, stderr=said,
                                        cwd=folder.name)
        cls.folder = os.path.realpath(folder.name)
        cls.drivers = {"": Driver("/omni", RATE), "left": Driver("/left", RATE), "flat": Driver("/wide", RATE)}
        cls.diagnostics = Ear("/diagnostics", DiagnosticArray)

    @classmethod
    def tearDownClass(cls):
        cls.node.send_signal(signal.SIGTERM)
        cls.node.wait(30)
        for driver in cls.drivers.values():
            driver.ends = True
        assert cls.node.returncode == 0, (cls.node.returncode, cls.text())

    @classmethod
    def text(cls):
        with open(cls.said, encoding="utf-8") as file:
            return file.read()

    def wait(self, what, seconds=20.0):
        deadline = time.time() + seconds
        while not what():
            self.assertLess(time.time(), deadline, self.text())
            time.sleep(0.01)

    def lean(self, *names):
        """Those hands, through the gate, then against the wall; again where the machine has stood still meanwhile."""
        drivers = [self.drivers[name] for name in names]
        for _ in range(10):
            for driver in drivers:
                driver.height = FREE
            self.wait(lambda: all(driver.at > FREE - 1e-3 for driver in drivers))
            time.sleep(0.6)
            for driver in drivers:
                driver.height = PRESSED
            deadline = time.time() + 2.0
            while time.time() < deadline:
                if all(driver.force > 0.9 * SOFT // 2 * DEEP for driver in drivers):
                    return
                time.sleep(0.01)
        self.fail(self.text())

    def rise(self):
        for driver in self.drivers.values():
            driver.height = FREE
        self.wait(lambda: all(driver.force == 0.0 for driver in self.drivers.values()))

    def statuses(self):
        return {status.name: status for status in self.diagnostics.all[-1].status}

    def test_1_each_hand_feels_for_itself(self):
        self.lean("left")
        self.assertEqual(self.drivers[""].force, 0.0)
        self.assertEqual(self.drivers["flat"].force, 0.0)
        with Ear("/palpate/left/contacts", MarkerArray) as left, Ear("/palpate/contacts", MarkerArray) as first:
            self.wait(lambda: len(left.all) > 3 and len(first.all) > 3)
            self.assertTrue(any(m.action == Marker.ADD for m in left.all[-1].markers))
            self.assertFalse(any(m.action == Marker.ADD for m in first.all[-1].markers))
        self.lean("left", "")
        self.wait(lambda: abs(self.drivers[""].force - SOFT * DEEP) < 0.05 * SOFT * DEEP
                  and abs(self.drivers["left"].force - SOFT // 2 * DEEP) < 0.05 * SOFT * DEEP)

    def test_2_a_hundred_contacts_are_read_back(self):
        self.rise()
        self.lean("flat")
        rows = wall_rows()
        with Ear("/palpate/flat/contacts", MarkerArray) as contacts:
            self.wait(lambda: contacts.all and sum(m.ns == "contacts" for m in contacts.all[-1].markers) >= 100)
            markers = contacts.all[-1].markers
        spheres = {m.id: m for m in markers if m.ns == "contacts" and m.action == Marker.ADD}
        print(f"{len(spheres)} contacts read back")
        self.assertEqual({m.id for m in markers if m.ns == "normals" and m.action == Marker.ADD}, set(spheres))
        for number, m in spheres.items():
            for at, want in zip((m.pose.position.x, m.pose.position.y, m.pose.position.z), rows[number][:3]):
                self.assertAlmostEqual(at, want, delta=1e-6)
            for size, log in zip(sorted((m.scale.x, m.scale.y, m.scale.z)), sorted(rows[number][10:13])):
                self.assertAlmostEqual(size, 2.0 * math.exp(log), delta=1e-6)

    def test_3_frames_and_diagnostics_are_told_of_each(self):
        with Ear("/tf", TFMessage) as transforms:
            self.wait(lambda: len(transforms.all) > 3)
        self.assertEqual({t.child_frame_id for t in transforms.all[-1].transforms},
                         {"palpate/scene"} | {f"palpate/{of}{frame}" for of in ("", "left/", "flat/", "far/") for frame in ("tool", "proxy")}
                         | {"palpate/device", "left_base", "palpate/flat/device", "palpate/far/device"})
        self.wait(lambda: self.diagnostics.all)
        self.assertEqual(set(self.statuses()), {f"palpate{of}: {what}" for of in ("", "/left", "/flat", "/far") for what in ("servo", "device", "scene")})

    def keep_their_force(self, spoil):
        """Whether the other hands press as before while the poses of one are spoilt until its force is gone."""
        others = [self.drivers[""], self.drivers["flat"]]
        left = self.drivers["left"]
        self.lean("", "left", "flat")
        time.sleep(0.3)
        before = [driver.force for driver in others]
        left.spoil = spoil
        self.wait(lambda: left.force == 0.0)
        self.wait(lambda: self.statuses()["palpate/left: device"].level == 2)
        left.spoil = lambda message: message
        kept = all(abs(driver.force - force) <= 1e-3 * force for driver, force in zip(others, before))
        return kept and self.statuses()["palpate: device"].level < 2

    def test_4_what_befalls_one_hand_leaves_the_others(self):
        def nan(message):
            message.pose.position.z = math.nan
            return message
        for what, spoil in (("NaN", nan), ("silence", lambda message: None)):
            with self.subTest(what=what):
                # A machine that stands still takes the force of all.
                self.assertTrue(any(self.keep_their_force(spoil) for _ in range(4)), self.text())
        self.assertIn("hand left: ros1:/left: poses of", self.text())
        self.assertNotRegex(self.text(), "palpate_ros1: ros1:/omni: poses of .* are not finite")

    def test_5_a_hand_has_a_stop_of_its_own_and_the_first_one_stops_all(self):
        def call(name):
            self.assertTrue(rospy.ServiceProxy(name, Trigger)().success)
        self.lean("", "left", "flat")
        call("/palpate/left/emergency_stop")
        self.wait(lambda: self.drivers["left"].force == 0.0)
        self.assertGreater(self.drivers[""].force, 0.0)
        self.assertGreater(self.drivers["flat"].force, 0.0)
        call("/palpate/left/resume")
        self.lean("left")
        call("/palpate/emergency_stop")
        self.wait(lambda: all(driver.force == 0.0 for driver in self.drivers.values()))
        for of in ("", "left/", "flat/", "far/"):
            call(f"/palpate/{of}resume")
        self.lean("", "left", "flat")

    def test_5b_a_hand_is_recorded_by_itself(self):
        def record(of, on):
            answer = rospy.ServiceProxy(f"/palpate/{of}record", SetBool)(on)
            return answer.success, answer.message
        done, path = record("left/", True)
        self.assertTrue(done, path)
        self.assertEqual(os.path.dirname(os.path.realpath(path)), self.folder)  # where the node was started
        self.assertTrue(os.path.basename(path).startswith("palpate-left-"), path)
        self.lean("left")
        self.assertEqual(record("", False), (False, "nothing is being recorded"))
        open_scene = rospy.Publisher("/palpate/open_scene", String, queue_size=1)
        self.wait(lambda: open_scene.get_num_connections() > 0)
        open_scene.publish("built-in")
        self.wait(lambda: "open_scene: a recording contains one scene only; stop it first" in self.text())
        self.assertEqual(record("left/", False), (True, path))
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        force = max(float(row["sfz"]) for row in rows)
        self.assertAlmostEqual(force, SOFT // 2 * DEEP, delta=0.1 * force)
        self.assertNotIn("/palpate/left/list_scenes", rosservice.get_service_list())  # the scene is that of the first

    def test_6_a_local_model_is_the_surface_about_the_handle(self):
        with Ear("/left/palpate/local_model", Float64MultiArray) as models:
            self.lean("left")
            self.wait(lambda: models.all and models.all[-1].data[8] == 1.0 and abs(models.all[-1].data[4] - PRESSED) < 1e-4)
            model = models.all[-1]
        force = SOFT // 2 * DEEP
        numbers = model.data
        dim = [(d.label, d.size, d.stride) for d in model.layout.dim]
        self.assertEqual((model.layout.data_offset, dim), (HEAD, [("planes", 1, PLANE), ("point, normal", PLANE, PLANE)]))
        self.assertEqual(len(numbers), HEAD + PLANE)
        self.assertLess(abs(numbers[0] + 1e-9 * numbers[1] - time.time()), 5.0)
        x, y, z, stiffness, _, friction, share = numbers[2:HEAD]
        self.assertAlmostEqual(z, PRESSED, delta=1e-3)
        self.assertEqual((x, y, stiffness, friction, share), (0.0, 0.0, SOFT // 2, 0.0, 1.0))
        point, normal = numbers[HEAD:HEAD + 3], numbers[HEAD + 3:]
        self.assertGreater(normal[2], 0.999)
        gap = sum(n * (a - b) for n, a, b in zip(normal, (x, y, z), point))
        self.assertAlmostEqual(-gap * stiffness, force, delta=0.02 * force)  # the force itself, from the plane alone

    def test_7_a_driver_renders_it(self):
        pattern = re.compile(r"z (\S+) m, shown (\S+) N, wrench (\S+) N; poses (\d+), answered (\d+), wrenches (\d+), lost (\d+), models (\d+); "
                             r"p50 (\S+) ms, p99 (\S+) ms")

        def is_right(line):
            z, shown, wrench, _, answered, _, _, models, _, _ = (float(text) for text in pattern.match(line).groups())
            is_of_the_model = abs(shown - STIFF * (0.02 - z)) < 0.05 * shown
            is_softer = wrench < 1.05 * shown  # by what it is late
            return shown > 1.0 and models > 500 and answered > 500 and is_of_the_model and is_softer

        for _ in range(8):  # on a busy machine a pose may be late, after which a hand that leans on feels nothing: it comes down again
            with subprocess.Popen([LOCAL_DRIVER, "/far", "0", "0", "0.014", "local"], stdout=subprocess.PIPE, text=True) as process:
                lines = [process.stdout.readline() for _ in range(6)]
                process.send_signal(signal.SIGINT)
            if any(is_right(line) for line in lines):
                break
        else:
            self.fail(lines)
        print(lines[-1].strip())

    def test_7b_a_driver_that_ends_lets_the_force_fall(self):
        for name, end in (("SIGTERM", lambda process: process.terminate()), ("rosnode kill", lambda _: end_by_name("/pressing"))):
            with self.subTest(end=name), subprocess.Popen([LOCAL_DRIVER, "/far", "0", "0", "0.014", "local", "__name:=pressing"],
                                                          stdout=subprocess.PIPE, text=True) as process:
                try:
                    # On a busy machine a pose may be late, and nothing is felt then: it ends well, too.
                    any(shown(process.stdout.readline()) > 1.0 for _ in range(6))
                    end(process)
                    said, _ = process.communicate(timeout=20)
                finally:
                    process.kill()
                self.assertRegex(said.splitlines()[-1], r"^fell to 0\.000 N in \d+ ms$")
                self.assertEqual(process.returncode, 0)

    def test_7c_a_force_that_nobody_renews_falls_though_the_wall_clock_is_set_back(self):
        back = os.path.join(self.folder, "back")
        for _ in range(4):  # as above
            with subprocess.Popen([LOCAL_DRIVER, "/far", "0", "0", "0.014", "local"], stdout=subprocess.PIPE, text=True,
                                  env={**os.environ, "LD_PRELOAD": CLOCK_BACK, "CLOCK_BACK": back}) as process:
                try:
                    if not any(shown(process.stdout.readline()) > 1.0 for _ in range(6)):
                        continue
                    self.node.send_signal(signal.SIGSTOP)
                    with open(back, "wb"):
                        pass
                    lines = [process.stdout.readline() for _ in range(2)]
                finally:
                    self.node.send_signal(signal.SIGCONT)
                    process.kill()
            break
        else:
            self.fail("it does not press")
        self.assertEqual(shown(lines[-1]), 0.0, lines)

    def test_7d_a_terminal_that_takes_no_text_holds_up_no_motors(self):
        read, write = os.pipe()
        self.addCleanup(os.close, read)
        fcntl.fcntl(write, fcntl.F_SETPIPE_SZ, 4096)
        os.write(write, b"\n" * 4096)
        with Ear("/far/measured_cp", PoseStamped) as poses:
            process = subprocess.Popen([LOCAL_DRIVER, "/far", "0", "0", "0.014", "local"], stdout=write)
            os.close(write)
            try:
                self.wait(lambda: poses.all)
                time.sleep(3.0)  # it has printed by then
                count = len(poses.all)
                self.wait(lambda: len(poses.all) > count + 10)
                process.send_signal(signal.SIGTERM)
                time.sleep(0.5)
                count = len(poses.all)
                time.sleep(0.2)
                self.assertEqual(len(poses.all), count)
                with os.fdopen(os.dup(read), encoding="ascii") as text:
                    self.assertRegex(text.read().splitlines()[-1], r"^fell to 0\.000 N in \d+ ms$")
                self.assertEqual(process.wait(20), 0)
            finally:
                process.kill()

    def test_8_a_lost_master_is_said_once(self):
        self.master.kill()
        self.wait(lambda: "lost the ROS master" in self.text())
        time.sleep(1.0)
        self.assertEqual(self.text().count("lost the ROS master"), 1, self.text())
        self.master.start()
        self.wait(lambda: "connected to the ROS master" in self.text())
        found = subprocess.run(["timeout", "20", "rostopic", "echo", "-n", "1", "/left/body/servo_cf"], capture_output=True, text=True, check=False)
        self.assertIn("force:", found.stdout, found.stderr)


class Refusals(unittest.TestCase):
    def test_bad_hands_are_one_line(self):
        port = free_port()
        master = Master(port)
        self.addCleanup(master.kill)
        for count, (words, *arguments) in enumerate((
            ("parameter 'hands': 'Left' must begin with a lower-case letter", "_hands:=Left"),
            ("parameter 'hands': there are two hands called 'left'", "_hands:=left,left"),
            ("there is no parameter 'left/scene'", "_hands:=left", "_left/scene:=x.ply"),
            ("parameter 'left/stiffness'", "_hands:=left", "_left/stiffness:=much"),
            ("there is no hand 'right' in 'hands'", "_hands:=left", "_right/stiffness:=300"),
            ("parameter 'left/device': /omni is the device of another hand", "_hands:=left", "_left/device:=/omni"),
            ("/nowhere.toml", "_hands:=left=/nowhere.toml"),
            ("parameter 'hands_touch': 'perhaps' is neither true nor false", "_hands_touch:=perhaps"),
        )):
            with self.subTest(arguments=arguments):
                # Under another name each time, so that the master keeps their parameters apart.
                result = subprocess.run([NODE, f"__name:=refused{count}", *arguments], capture_output=True, text=True, check=False, timeout=60,
                                        env={**os.environ, "ROS_MASTER_URI": f"http://127.0.0.1:{port}"})
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertIn(words, result.stderr)
                self.assertEqual(result.stderr.count("\n"), 1, result.stderr)


if __name__ == "__main__":
    unittest.main()
