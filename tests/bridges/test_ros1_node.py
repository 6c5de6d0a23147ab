"""The node palpate_ros1 with a real roscore: what it publishes, its services and parameters, and what ends and does not end it."""

import csv
import ctypes
import json
import math
import os
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import xmlrpc.client
import xmlrpc.server
from collections import Counter
from socketserver import ThreadingMixIn
from threading import Thread

import rospy
import rosservice
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from ros1_support import FREE, PRESSED, Driver, Ear, Master, end_by_name, free_port, newest_line

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../cli"))
from support import PALPATE, ply, threads_of, wall_rows  # noqa: E402

NODE = os.environ["PALPATE_ROS1"]
PACKAGES = os.environ["PALPATE_ROS1_PACKAGES"]
OK, WARN, ERROR = 0, 1, 2
DECIMATION = 7
LOW = -0.1  # height of the other wall. Unit: [m]


def low_rows():
    return [(row[0], row[1], LOW, *row[3:]) for row in wall_rows()]


def lost_rows():
    """Which are nowhere: nobody can feel them."""
    return [(math.nan, *row[1:]) for row in wall_rows()]


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def is_unit(q):
    return abs(math.sqrt(q.x**2 + q.y**2 + q.z**2 + q.w**2) - 1.0) < 1e-9


class Node(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        port = free_port()
        os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
        os.environ["ROS_IP"] = "127.0.0.1"
        cls.folder = tempfile.TemporaryDirectory()
        os.environ["ROS_LOG_DIR"] = os.environ["ROS_HOME"] = cls.folder.name
        os.environ["ROS_PACKAGE_PATH"] = PACKAGES
        cls.scene = os.path.join(cls.folder.name, "wall.ply")
        with open(cls.scene, "wb") as file:
            file.write(ply(wall_rows()))
        cls.scenes = os.path.join(cls.folder.name, "scenes")
        cls.runs = os.path.join(cls.folder.name, "runs")
        os.mkdir(cls.scenes)
        os.mkdir(cls.runs)
        with open(os.path.join(cls.scenes, "low.ply"), "wb") as file:
            file.write(ply(low_rows()))
        with open(os.path.join(cls.scenes, "lost.ply"), "wb") as file:
            file.write(ply(lost_rows()))
        cls.said = os.path.join(cls.folder.name, "said")
        # Before there is a master: it waits, and says so.
        with open(cls.said, "ab") as said:
            cls.run_ = subprocess.Popen([NODE, "__name:=palpate"], stdin=subprocess.DEVNULL, stdout=said, stderr=said)
        cls.wait_said("there is no ROS master at")
        cls.run_.kill()
        cls.run_.wait()
        cls.master = Master(port)
        rospy.init_node("driver", disable_signals=True, disable_rosout=True)
        cls.driver = Driver()
        cls.start_node()
        cls.diagnostics = Ear("/diagnostics", DiagnosticArray)

    @classmethod
    def start_node(cls):
        with open(cls.said, "ab") as said:
            cls.run_ = subprocess.Popen([NODE, "__name:=palpate", f"_scene:={cls.scene}", "_no_index_file:=true", "_tool:=0.02,0.02,0.02",
                                         "_device:=/arm,force_max=8,rate=20", f"_cloud_decimation:={DECIMATION}", "_device_frame:=base",
                                         f"_scenes:={cls.scenes}", f"_recordings:={cls.runs}",
                                         "_workspace_offset:=0,0,0", "/arm/measured_cp:=/omni/measured_cp",
                                         "/arm/spatial/servo_cf:=/omni/spatial/servo_cf", "/arm/body/servo_cf:=/omni/body/servo_cf",
                                         "/arm/palpate/echo:=/omni/palpate/echo", "/arm/palpate/echoed:=/omni/palpate/echoed"],
                                        stdin=subprocess.DEVNULL, stdout=said, stderr=said)

    @classmethod
    def tearDownClass(cls):
        cls.run_.send_signal(signal.SIGTERM)
        cls.run_.wait(30)
        assert cls.run_.returncode == 0, (cls.run_.returncode, cls.text())
        cls.driver.ends = True
        cls.master.kill()
        cls.folder.cleanup()

    @classmethod
    def text(cls):
        with open(cls.said, encoding="utf-8") as file:
            return file.read()

    @classmethod
    def wait_said(cls, words, count=1):
        deadline = time.time() + 20
        while cls.text().count(words) < count:
            if time.time() > deadline:
                raise AssertionError(f"does not say {words!r}: {cls.text()}")
            time.sleep(0.05)

    def wait(self, what, seconds=20.0):
        deadline = time.time() + seconds
        while not what():
            self.assertLess(time.time(), deadline, self.text())
            time.sleep(0.01)

    def lean(self):
        """Through the gate, then against the wall; again where the machine has stood still meanwhile."""
        for _ in range(10):
            self.driver.height = FREE
            self.wait(lambda: self.driver.at > FREE - 1e-3)
            time.sleep(0.6)
            self.driver.height = PRESSED
            deadline = time.time() + 2.0
            while time.time() < deadline:
                if self.driver.force > 0.5:
                    return
                time.sleep(0.01)
        self.fail(self.text())

    def status(self, name):
        for status in self.diagnostics.all[-1].status:
            if status.name == name:
                return status, {pair.key: pair.value for pair in status.values}
        raise AssertionError(name)

    def wait_status(self, name, level, message=""):
        def found():
            if not self.diagnostics.all:
                return False
            status, _ = self.status(name)
            return status.level == level and message in status.message
        self.wait(found)
        return self.status(name)

    def call(self, name, *arguments):
        answer = rospy.ServiceProxy(name, SetBool if arguments else Trigger)(*arguments)
        self.assertTrue(answer.success, answer.message)
        return answer.message

    def refuse(self, words, name, *arguments):
        answer = rospy.ServiceProxy(name, SetBool if arguments else Trigger)(*arguments)
        self.assertFalse(answer.success)
        self.assertIn(words, answer.message)
        self.assertNotIn("\n", answer.message)

    def parameters(self):
        return json.loads(self.call("/palpate/get_parameters"))

    def publisher(self, topic):
        publisher = rospy.Publisher(topic, String, queue_size=4)
        self.wait(lambda: publisher.get_num_connections() > 0)
        return publisher

    def says(self, words, work):
        """The line that `work` has the node say, and no other."""
        before = len(self.text().splitlines())
        work()
        self.wait(lambda: words in "".join(self.text().splitlines(keepends=True)[before:]))
        self.assertEqual([line for line in self.text().splitlines()[before:] if words not in line], [])

    def test_1_markers_are_valid(self):
        self.lean()
        with Ear("/palpate/contacts", MarkerArray) as contacts, Ear("/palpate/tool", MarkerArray) as tool:
            self.wait(lambda: len(contacts.all) > 3 and tool.all)
            self.check_contacts(contacts.all[-1].markers)
            tool = tool.all[-1].markers
            self.assertEqual([(m.ns, m.id, m.type, m.header.frame_id) for m in tool], [("tool", 0, Marker.SPHERE, "world")])
            self.assertAlmostEqual(tool[0].scale.x, 0.04)
            # What is gone is deleted.
            self.driver.height = FREE
            self.wait(lambda: any(m.action == Marker.DELETE for m in contacts.all[-1].markers))
            self.wait(lambda: not any(m.action == Marker.ADD for m in contacts.all[-1].markers))

    def check_contacts(self, markers):
        shown = {(m.ns, m.id): m for m in markers if m.action == Marker.ADD}
        self.assertGreater(len(shown), 0)
        for m in markers:
            self.assertEqual(m.header.frame_id, "world")
            self.assertLess(abs(m.header.stamp.to_sec() - time.time()), 5.0)
            self.assertIn(m.action, (Marker.ADD, Marker.DELETE))
        for (ns, number), m in shown.items():
            self.assertIn(ns, ("contacts", "normals"))
            self.assertTrue(0 <= number < len(wall_rows()))
            self.assertTrue(is_unit(m.pose.orientation))
            self.assertTrue(all(0.0 <= c <= 1.0 for c in (m.color.r, m.color.g, m.color.b, m.color.a)))
            self.assertEqual(m.lifetime.to_sec(), 0.0)
            if ns == "contacts":
                self.assertEqual(m.type, Marker.SPHERE)
                # Where the file has that Gaussian, and as large.
                row = wall_rows()[number]
                for at, want in zip((m.pose.position.x, m.pose.position.y, m.pose.position.z), row[:3]):
                    self.assertAlmostEqual(at, want, delta=1e-6)
                for size, log in zip(sorted((m.scale.x, m.scale.y, m.scale.z)), sorted(row[10:13])):
                    self.assertAlmostEqual(size, 2.0 * math.exp(log), delta=1e-6)
                self.assertIn(("normals", number), shown)
            else:
                self.assertEqual(m.type, Marker.ARROW)
                self.assertEqual(len(m.points), 2)
                self.assertGreaterEqual(m.points[1].z, m.points[0].z)  # out of the wall
                self.assertGreater(m.scale.x, 0.0)

    def test_2_frames_are_where_things_are(self):
        for _ in range(10):  # again where the machine has stood still meanwhile
            self.lean()
            with Ear("/tf", TFMessage) as transforms:
                self.wait(lambda: len(transforms.all) > 3)
            frames = {t.child_frame_id: t for m in transforms.all[-3:] for t in m.transforms if t.header.frame_id == "world"}
            if self.driver.force > 0.5:
                break
        self.assertEqual(set(frames), {"base", "palpate/scene", "palpate/tool", "palpate/proxy"})
        for t in frames.values():
            self.assertTrue(is_unit(t.transform.rotation))
        self.assertAlmostEqual(frames["palpate/tool"].transform.translation.z, PRESSED, delta=1e-3)
        self.assertGreater(frames["palpate/proxy"].transform.translation.z, PRESSED + 1e-4)  # the wall holds it back

    def test_3_centres_are_kept_for_who_comes_later(self):
        with Ear("/palpate/centers", PointCloud2) as centers:
            self.wait(lambda: centers.all)
        cloud = centers.all[0]
        rows = wall_rows()[::DECIMATION]
        self.assertEqual((cloud.header.frame_id, cloud.height, cloud.width), ("world", 1, len(rows)))
        self.assertEqual([(f.name, f.offset, f.datatype, f.count) for f in cloud.fields],
                         [(n, 4 * k, PointField.FLOAT32, 1) for k, n in enumerate("xyz")])
        self.assertEqual((cloud.point_step, cloud.row_step, cloud.is_dense, cloud.is_bigendian), (12, 12 * len(rows), True, False))
        points = list(struct.iter_unpack("<3f", cloud.data))
        self.assertEqual(len(points), len(rows))
        for point in points:
            self.assertAlmostEqual(point[2], 0.0, delta=1e-6)
            self.assertLessEqual(max(abs(point[0]), abs(point[1])), 0.1 + 1e-6)

    def test_4_services_stop_the_force_and_give_it_back(self):
        for stop, level, begin in ((("/palpate/emergency_stop",), ERROR, ("/palpate/resume",)),
                                   (("/palpate/pause", True), ERROR, ("/palpate/pause", False)),
                                   (("/palpate/clutch", True), WARN, ("/palpate/clutch", False))):
            with self.subTest(service=stop[0]):
                self.lean()
                self.call(*stop)
                self.wait(lambda: self.driver.force == 0.0)
                status, values = self.wait_status("palpate: servo", level)
                self.assertEqual(values["fault"], status.message)
                self.assertTrue(values["advice"])
                self.call(*begin)  # of the clutch: where it was pressed, so that the tool is where the hand is
                self.lean()
                self.wait_status("palpate: servo", OK)

    def test_4b_settings_are_read_and_changed(self):
        self.assertEqual(self.parameters()["stiffness"], 500)
        change = self.publisher("/palpate/set_parameters")
        change.publish('{"stiffness": 300, "tool": [{"semi_axes": [0.01, 0.01, 0.01]}]}')
        self.wait(lambda: self.parameters()["stiffness"] == 300)
        self.assertIn("stiffness = 300", self.call("/palpate/config"))
        with Ear("/palpate/tool", MarkerArray) as tool:
            self.wait(lambda: tool.all and abs(tool.all[-1].markers[0].scale.x - 0.02) < 1e-9)
        for text, words in (('{"stiffness": -1}', "stiffness"), ('{"device": {}}', "parameters has no 'device'"), ("[]", "'parameters' must be an object"),
                            ("{", "set_parameters: ")):
            count = self.text().count("set_parameters: ")
            change.publish(text)
            self.wait_said("set_parameters: ", count + 1)
            self.assertIn(words, newest_line(self.text(), "set_parameters: "))
        change.publish('{"stiffness": 500, "tool": [{"semi_axes": [0.02, 0.02, 0.02]}]}')
        self.wait(lambda: self.parameters()["stiffness"] == 500)

    def test_4c_a_recording_is_begun_and_ended(self):
        self.refuse("nothing is being recorded", "/palpate/record", False)
        path = self.call("/palpate/record", True)
        self.assertEqual(os.path.dirname(path), self.runs)
        self.assertRegex(os.path.basename(path), r"^palpate-\d{4}(-\d\d){5}\.csv$")
        self.refuse("a recording is under way", "/palpate/record", True)
        self.assertEqual(self.parameters()["recording"], path)
        self.wait(lambda: self.status("palpate: scene")[1]["recording"] == path)
        self.lean()
        open_scene = self.publisher("/palpate/open_scene")
        self.says("open_scene: a recording contains one scene only; stop it first", lambda: open_scene.publish(""))
        self.wait(lambda: len(rows_of(path)) > 100)  # while it is made
        self.assertEqual(self.call("/palpate/record", False), path)
        rows = rows_of(path)
        self.assertEqual(self.parameters()["recording"], "")
        times = [float(row["t"]) for row in rows]
        self.assertEqual(times, sorted(times))
        self.assertLess(min(float(row["z"]) for row in rows), PRESSED + 1e-3)
        self.assertGreater(max(float(row["sfz"]) for row in rows), 0.5)
        time.sleep(0.2)
        self.assertEqual(len(rows_of(path)), len(rows))
        again = os.path.join(self.runs, "again.csv")
        replay = subprocess.run([PALPATE, "replay", "--from", path, "--out", again], capture_output=True, text=True, check=False, timeout=120)
        self.assertEqual(replay.returncode, 0, replay.stderr)
        pose = ("t", "x", "y", "z", "qw", "qx", "qy", "qz")
        self.assertEqual([[row[name] for name in pose] for row in rows_of(again)], [[row[name] for name in pose] for row in rows])
        second = self.call("/palpate/record", True)
        self.assertNotEqual(second, path)
        self.assertEqual(self.call("/palpate/record", False), second)

    def test_4c_b_a_full_disk_ends_a_recording_and_nothing_else(self):
        limit = resource.prlimit(self.run_.pid, resource.RLIMIT_FSIZE)
        path = self.call("/palpate/record", True)
        try:
            resource.prlimit(self.run_.pid, resource.RLIMIT_FSIZE, (100_000, limit[1]))
            self.wait_said("the recording has ended: ")
        finally:
            resource.prlimit(self.run_.pid, resource.RLIMIT_FSIZE, limit)
        self.assertIn(f"the data up to then is in {path}", self.text())
        self.refuse("nothing is being recorded", "/palpate/record", False)
        self.assertEqual(self.parameters()["recording"], "")
        self.assertGreater(len(rows_of(path)), 100)
        self.lean()
        self.assertNotEqual(self.call("/palpate/record", True), path)
        self.call("/palpate/record", False)

    def test_4d_another_scene_is_felt(self):
        known = {entry["name"]: entry["id"] for entry in json.loads(self.call("/palpate/list_scenes"))}
        self.assertEqual(set(known), {"The built-in still life", "wall.ply", "low.ply", "lost.ply"})
        open_scene, change = self.publisher("/palpate/open_scene"), self.publisher("/palpate/set_parameters")
        self.lean()
        with Ear("/palpate/contacts", MarkerArray) as contacts, Ear("/palpate/centers", PointCloud2) as centers:
            self.wait(lambda: centers.all and contacts.all and any(m.action == Marker.ADD for m in contacts.all[-1].markers))

            def wait_centers(height):
                self.wait(lambda: all(abs(p[2] - height) < 1e-6 for p in struct.iter_unpack("<3f", centers.all[-1].data)))
            wait_centers(0.0)
            self.says("low.ply is active", lambda: open_scene.publish(known["low.ply"]))
            self.assertEqual(self.parameters()["scene"], {"name": "low.ply", "path": os.path.join(self.scenes, "low.ply")})
            self.wait(lambda: self.status("palpate: scene")[1]["scene"].endswith("low.ply"))
            wait_centers(LOW)
            self.wait(lambda: self.driver.force == 0.0)
            self.wait(lambda: not any(m.action == Marker.ADD for m in contacts.all[-1].markers))
            # Where it is, is as the file has it, until somebody says so.
            change.publish(json.dumps({"registration": {"translation": [0, 0, -LOW]}}))
            self.wait(lambda: self.parameters()["registration"]["translation"] == [0, 0, -LOW])
            wait_centers(0.0)
            self.lean()
            self.wait(lambda: any(m.action == Marker.ADD for m in contacts.all[-1].markers))
        self.says("wall.ply is active", lambda: open_scene.publish(self.scene))  # by its path
        self.assertEqual(self.parameters()["registration"]["translation"], [0, 0, 0])
        self.lean()

    def test_4e_what_is_no_scene_is_refused_and_the_old_one_stays(self):
        open_scene = self.publisher("/palpate/open_scene")
        for which, words in (("/nowhere/at/all.ply", "/nowhere/at/all.ply"), (self.said, self.said), (self.scenes, self.scenes),
                             ("low", "there is no scene 'low'")):
            with self.subTest(which=which):
                self.says("open_scene: ", lambda which=which: open_scene.publish(which))
                self.assertIn(words, newest_line(self.text(), "open_scene: "))
        # What is wrong with a scene is found while it is read.
        refusal = "lost.ply: no Gaussian passes the filter; the current scene stays"
        for count in (1, 2):
            open_scene.publish(os.path.join(self.scenes, "lost.ply"))
            self.wait_said(refusal, count)
        self.wait_status("palpate: scene", WARN, refusal)
        self.assertEqual(self.parameters()["scene"]["path"], self.scene)
        self.lean()

    def test_5_what_is_wrong_with_poses_is_in_the_diagnostics(self):
        for level, message, notice, change in (
            (ERROR, "not finite", "no force until valid poses arrive", lambda m: setattr(m.pose.position, "z", math.nan)),
            (ERROR, "not of unit norm", "no force until valid poses arrive", lambda m: setattr(m.pose.orientation, "w", 2.0)),
            (ERROR, "wrong frame_id", "in the frame 'elsewhere', not 'base'", lambda m: setattr(m.header, "frame_id", "elsewhere")),
            (ERROR, "poses are late", "late, repeated or out of order", lambda m: setattr(m.header, "stamp", m.header.stamp - rospy.Duration(0.5))),
            (ERROR, "future", "stamps in the future", lambda m: setattr(m.header, "stamp", m.header.stamp + rospy.Duration(5))),
        ):
            with self.subTest(what=message):
                self.lean()
                self.wait_status("palpate: device", OK)

                def spoil(m, change=change):
                    change(m)
                    return m
                self.driver.spoil = spoil
                self.wait(lambda: self.driver.force == 0.0)
                if message != "future":  # a clock that was set is believed after a second
                    _, values = self.wait_status("palpate: device", level, message)
                    self.assertIn(notice, values["notice"])
                    self.assertGreater(int(values["dropped"]), 0)
                else:
                    self.wait_said(notice)
                self.driver.spoil = lambda m: m
                self.wait_status("palpate: device", OK)
        other = subprocess.Popen(["rostopic", "pub", "-r", "50", "/omni/measured_cp", "geometry_msgs/PoseStamped",
                                  "{header: auto, pose: {position: {z: 0.3}, orientation: {w: 1.0}}}"],
                                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            self.wait_status("palpate: device", WARN, "poses are dropped")
            self.wait(lambda: "controls the device until it is silent for 1 s" in self.status("palpate: device")[1]["notice"])
        finally:
            other.kill()
            other.wait()
        self.driver.spoil = lambda m: None
        self.wait_status("palpate: device", ERROR, "no poses received")
        self.driver.spoil = lambda m: m
        self.lean()

    def test_6_the_master_is_killed_and_started_again(self):
        self.lean()
        self.master.kill()
        self.wait_said("lost the ROS master")
        wrenches, statuses = self.driver.wrenches, len(self.diagnostics.all)
        self.wait(lambda: self.driver.wrenches > wrenches + 20 and len(self.diagnostics.all) > statuses + 3)  # connections stay
        self.master.start()
        self.wait_said("connected to the ROS master")
        self.wait(lambda: {"/palpate/emergency_stop", "/palpate/record"} <= set(rosservice.get_service_list()))
        self.call("/palpate/pause", True)
        self.wait(lambda: self.driver.force == 0.0)
        self.call("/palpate/pause", False)
        found = subprocess.run(["timeout", "20", "rostopic", "echo", "-n", "1", "/palpate/tool"], capture_output=True, text=True, check=False)
        self.assertIn("ns: \"tool\"", found.stdout, found.stderr)
        for stiffness in (400, 500):  # a publisher that the new master alone knows
            subprocess.run(["timeout", "20", "rostopic", "pub", "-1", "/palpate/set_parameters", "std_msgs/String",
                            f'data: "{{\\"stiffness\\": {stiffness}}}"'], capture_output=True, check=True)
            self.wait(lambda: self.parameters()["stiffness"] == stiffness)

    def test_6b_a_service_that_the_master_has_lost_is_registered_again(self):
        master, service = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]), "/palpate/emergency_stop"
        rospy.wait_for_service(service, 20)
        where = master.lookupService("/test", service)[2]
        rospy.wait_for_service("/palpate/get_parameters", 20)
        # Connections to it and to another one, which both stay.
        stop, parameters = (rospy.ServiceProxy(name, Trigger, persistent=True) for name in (service, "/palpate/get_parameters"))
        self.addCleanup(stop.close)
        self.addCleanup(parameters.close)
        self.assertTrue(parameters().success)
        self.assertTrue(stop().success)
        self.assertEqual(master.unregisterService("/palpate", service, where)[2], 1)
        self.wait(lambda: service in rosservice.get_service_list(), 5.0)
        self.assertEqual(master.lookupService("/test", service)[2], where)
        time.sleep(0.5)  # after another look at the master
        self.assertTrue(parameters().success)
        self.assertTrue(stop().success)
        self.call("/palpate/resume")
        self.call(service)  # also for who comes now
        self.call("/palpate/resume")
        self.lean()

    def test_7_every_pose_is_answered_or_counted(self):
        self.lean()
        driver = self.driver
        driver.round_trips.clear()
        sent, wrenches, begin = driver.sent, driver.wrenches, time.time()
        time.sleep(2.0)
        seconds = time.time() - begin
        trips = sorted(driver.round_trips)
        poses = driver.sent - sent
        print(f"poses {poses / seconds:.0f} Hz, wrenches {(driver.wrenches - wrenches) / seconds:.0f} Hz, answered {len(trips)} of {poses} "
              f"({100.0 * (1.0 - len(trips) / poses):.1f} % passed over for a newer one); round trip p50 {1e3 * trips[len(trips) // 2]:.2f} ms, "
              f"p99 {1e3 * trips[int(0.99 * len(trips))]:.2f} ms")
        self.assertGreater(len(trips), 100)

    def test_8_poses_pass_through_real_time_threads_only(self):
        threads = {}  # name: {(policy, priority)}
        for thread, name in threads_of(self.run_.pid).items():
            threads.setdefault(name, set()).add((os.sched_getscheduler(thread), os.sched_getparam(thread).sched_priority))
        [(policy, priority)] = threads["palpate-servo"]
        if policy != os.SCHED_FIFO:
            self.skipTest("real-time priority is not permitted here")
        below = (os.SCHED_FIFO, priority - 10)
        self.assertEqual(threads["palpate-ros1"], {below})
        self.assertEqual(threads["palpate-sender"], {(os.SCHED_OTHER, 0)}, "wrenches take no time from a driver")
        self.assertIn(below, threads["palpate_ros1"], "roscpp's, which reads the sockets, has the name of the program")

    def test_5b_a_node_that_ros_ends_sends_zero_last(self):
        namesake = []

        def start_namesake():
            namesake.append(subprocess.Popen([NODE, "__name:=palpate", "_device:=/elsewhere", "_hands:="], stdin=subprocess.DEVNULL,
                                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        for what, end in (("rosnode kill", lambda: end_by_name("/palpate")), ("another node of the same name", start_namesake)):
            with self.subTest(what=what):
                self.lean()
                wrenches = self.driver.wrenches
                end()
                self.run_.wait(30)
                time.sleep(0.3)
                self.assertEqual(self.driver.force, 0.0)
                self.assertGreater(self.driver.wrenches, wrenches + 20, "it falls")
                self.assertEqual(self.run_.returncode, 0)
                for other in namesake:
                    other.terminate()
                    other.wait(30)
                self.start_node()
        self.lean()


    def test_5c_the_force_falls_at_once_though_the_main_thread_is_busy(self):
        self.lean()
        uri = rospy.get_master().lookupNode("/palpate")[2]
        with Stopped(self.run_.pid):
            time.sleep(0.3)
            self.assertGreater(self.driver.force, 0.5, "the loop goes on")
            xmlrpc.client.ServerProxy(uri).shutdown("/test", "by the test")
            self.wait(lambda: self.driver.force == 0.0, 5.0)
            time.sleep(0.3)
            self.assertEqual(self.driver.force, 0.0)
        self.assertEqual(self.run_.wait(30), 0)
        self.start_node()
        self.lean()


class Stopped:
    """The main thread of a child alone stands still, as one that waits for a disk does."""
    ATTACH, DETACH, ANY_THREAD = 16, 17, 0x40000000

    def __init__(self, thread):
        self.thread = thread

    def trace(self, request):
        libc = ctypes.CDLL(None, use_errno=True)
        none = ctypes.c_void_p()
        if libc.ptrace(ctypes.c_long(request), ctypes.c_long(self.thread), none, none) != 0:
            raise unittest.SkipTest(f"ptrace: {os.strerror(ctypes.get_errno())}")

    def __enter__(self):
        self.trace(self.ATTACH)
        os.waitpid(self.thread, self.ANY_THREAD)

    def __exit__(self, *_):
        self.trace(self.DETACH)


class Refusals(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.port = free_port()
        master = Master(cls.port)
        cls.addClassCleanup(master.kill)
        cls.count = 0

    def refuse(self, words, *arguments, env=None):
        Refusals.count += 1  # under another name each time, so that the master keeps their parameters apart
        result = subprocess.run([NODE, f"__name:=palpate{self.count}", *arguments], capture_output=True, text=True, check=False, timeout=60,
                                env={**os.environ, "ROS_MASTER_URI": f"http://127.0.0.1:{self.port}", **(env or {})})
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertTrue(result.stderr.startswith("palpate_ros1: "), result.stderr)
        self.assertIn(words, result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)

    def test_bad_parameters_are_one_line(self):
        for argument, words in {
            "_stifness:=300": "there is no parameter 'stifness'",
            "_stiffness:=much": "parameter 'stiffness'",
            "_cloud_decimation:=0": "parameter 'cloud_decimation': 0 is not a whole number of 1 or more",
            "_device:=omni": "needs the prefix of the device's topics",
            "_device_frame:=/base": "parameter 'device_frame'",
            "_recordings:=/nowhere": "parameter 'recordings': '/nowhere' is not a folder",
            "_scenes:=/nowhere": "parameter 'scenes': /nowhere",
            "_scene:=/nowhere.ply": "/nowhere.ply",
            "_config:=/nowhere.toml": "/nowhere.toml",
            "--halp": "'--halp' is not an argument",
        }.items():
            with self.subTest(argument=argument):
                self.refuse(words, argument)

    def test_help_needs_no_master(self):
        for argument in ("--help", "-h"):
            result = subprocess.run([NODE, argument], env={**os.environ, "ROS_MASTER_URI": ""}, capture_output=True, text=True, timeout=60)
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            self.assertIn("Usage: palpate_ros1 [_PARAMETER:=VALUE]... [FROM:=TO]...\n", result.stdout)
            self.assertIn("left/stiffness", result.stdout)

    def test_no_master_is_named(self):
        self.refuse("ROS_MASTER_URI is not set", env={"ROS_MASTER_URI": ""})
        self.refuse("ROS_MASTER_URI is not of the form http://HOST:PORT", env={"ROS_MASTER_URI": "somewhere"})


class KeepsConnections(xmlrpc.server.SimpleXMLRPCRequestHandler):
    protocol_version = "HTTP/1.1"


class SlowMaster(ThreadingMixIn, xmlrpc.server.SimpleXMLRPCServer):
    """In front of a master: what concerns services is answered late. Counts requests, by method and service."""
    daemon_threads = True
    DELAY = {"registerService": 0.3, "getSystemState": 1.0}  # Unit: [s]

    def __init__(self, uri):
        super().__init__(("127.0.0.1", 0), KeepsConnections, logRequests=False)
        self.uri, self.counts = uri, Counter()
        Thread(target=self.serve_forever, daemon=True).start()

    def _dispatch(self, method, params):
        if method in ("registerService", "unregisterService"):
            self.counts[method, params[1]] += 1
        answer = getattr(xmlrpc.client.ServerProxy(self.uri), method)(*params)
        time.sleep(self.DELAY.get(method, 0.0))
        return answer


class Slow(unittest.TestCase):
    def test_a_node_that_starts_at_a_slow_master_advertises_each_service_once(self):
        port = free_port()
        master = Master(port)
        self.addCleanup(master.kill)
        uri = f"http://127.0.0.1:{port}"
        slow = SlowMaster(uri)
        self.addCleanup(slow.shutdown)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        scene = os.path.join(folder.name, "wall.ply")
        with open(scene, "wb") as file:
            file.write(ply(wall_rows()))
        node = subprocess.Popen([NODE, "__name:=palpate", f"_scene:={scene}", "_no_index_file:=true", "_device:=/arm,rate=20"],
                                stdin=subprocess.DEVNULL, env={**os.environ, "ROS_LOG_DIR": folder.name,
                                                               "ROS_MASTER_URI": f"http://127.0.0.1:{slow.server_address[1]}"})
        try:
            services = {f"/palpate/{name}" for name in ("emergency_stop", "pause", "resume", "clutch", "config", "get_parameters",
                                                        "list_scenes", "record")}
            deadline = time.time() + 30
            while not services <= {name for _, name in slow.counts}:
                self.assertLess(time.time(), deadline, slow.counts)
                time.sleep(0.05)
            time.sleep(2.5 * SlowMaster.DELAY["getSystemState"])  # for another look at the master
            self.assertEqual(dict(slow.counts), {("registerService", name): 1 for _, name in slow.counts})
        finally:
            node.send_signal(signal.SIGTERM)
            self.assertEqual(node.wait(30), 0)


if __name__ == "__main__":
    unittest.main()
