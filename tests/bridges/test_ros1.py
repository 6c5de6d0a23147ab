"""palpate run --device ros1:/omni with a real roscore, and a driver that is an ordinary rospy node."""

import json
import math
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import xmlrpc.client

import rospy

from geometry_msgs.msg import WrenchStamped

from ros1_support import FREE, PRESSED, Driver, Ear, Master, end_by_name, free_port, newest_line

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../cli"))
from support import ply, wall_rows  # noqa: E402

PALPATE = os.environ["PALPATE"]


def invalid_stamp(seconds):
    stamp = rospy.Time()
    stamp.secs, stamp.nsecs = seconds, 0xffffffff
    return stamp


def other_address():
    """One of this host that others may reach it at; None: there is none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # of no host; nothing is sent
        except OSError:
            return None
        address = probe.getsockname()[0]
    return None if address.startswith("127.") else address


class Ros1(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        port = free_port()
        os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
        os.environ["ROS_IP"] = "127.0.0.1"
        cls.folder = tempfile.TemporaryDirectory()
        os.environ["ROS_LOG_DIR"] = os.environ["ROS_HOME"] = cls.folder.name
        cls.scene = scene = os.path.join(cls.folder.name, "wall.ply")
        with open(scene, "wb") as file:
            file.write(ply(wall_rows()))
        cls.said = os.path.join(cls.folder.name, "said")
        # Before there is a master: it waits, and says so.
        with open(cls.said, "ab") as said:
            cls.run_ = subprocess.Popen([PALPATE, "run", scene, "--no-gateway", "--no-index-file", "--tool", "0.02,0.02,0.02",
                                         "--device", "ros1:/omni,force_max=8,rate=20", "--json"],
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=said,
                                        env={**os.environ, "LD_PRELOAD": os.environ["PALPATE_TWO_ADDRESSES"]})
        cls.wait_said("there is no ROS master at")
        cls.master = Master(port)
        rospy.init_node("driver", disable_signals=True, disable_rosout=True)
        cls.driver = Driver()

    @classmethod
    def tearDownClass(cls):
        cls.run_.send_signal(signal.SIGTERM)
        out, _ = cls.run_.communicate(timeout=30)
        summary = json.loads(out)
        print("servo:", summary["ticks"], "ticks at", round(summary["rate_hz"]), "Hz, force age p50/p99",
              round(summary["age_us"]["p50"]), round(summary["age_us"]["p99"]), "us, faults", summary["faults"])
        assert cls.run_.returncode == 0, cls.run_.returncode
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

    def lean(self, driver=None):
        """Through the gate, then against the wall; again where the machine has stood still meanwhile."""
        driver = driver or self.driver
        for _ in range(10):
            driver.height = FREE
            self.wait(lambda: driver.at > FREE - 1e-3)
            time.sleep(0.6)
            driver.height = PRESSED
            deadline = time.time() + 2.0
            while time.time() < deadline:
                if driver.force > 0.5:
                    return
                time.sleep(0.01)
        self.fail(self.text())

    def test_1_a_wall_is_felt_and_every_tick_answers(self):
        self.lean()
        driver = self.driver
        driver.round_trips.clear()
        sent, wrenches, body, begin = driver.sent, driver.wrenches, driver.body, time.time()
        time.sleep(1.0)
        seconds = time.time() - begin
        trips = sorted(driver.round_trips)
        print(f"poses {(driver.sent - sent) / seconds:.0f} Hz, wrenches {(driver.wrenches - wrenches) / seconds:.0f} Hz, "
              f"answered {len(trips)} of {driver.sent - sent}; round trip p50 {1e3 * trips[len(trips) // 2]:.2f} ms, "
              f"p99 {1e3 * trips[int(0.99 * len(trips))]:.2f} ms")
        self.assertGreater(len(trips), 50)
        self.assertGreater(driver.wrenches - wrenches, 50)
        self.assertGreater(driver.body - body, 50)
        self.assertEqual(driver.body_frame, "tool")

    def test_2_what_is_no_pose_ends_the_force_and_is_said_once(self):
        for name, words, change in (
            ("NaN", "no force until valid poses arrive", lambda m: setattr(m.pose.position, "z", math.nan)),
            ("norm", "no force until valid poses arrive", lambda m: setattr(m.pose.orientation, "w", 2.0)),
            ("frame", "in the frame 'elsewhere', not 'base'", lambda m: setattr(m.header, "frame_id", "elsewhere")),
            ("future", "stamps in the future and are dropped", lambda m: setattr(m.header, "stamp", m.header.stamp + rospy.Duration(5))),
            ("stamp", "invalid stamps and are dropped", lambda m: setattr(m.header, "stamp", invalid_stamp(0))),
            ("no time", "invalid stamps and are dropped", lambda m: setattr(m.header, "stamp", invalid_stamp(0xffffffff))),
            ("stale", "late, repeated or out of order", lambda m: setattr(m.header, "stamp", m.header.stamp - rospy.Duration(0.5))),
        ):
            with self.subTest(what=name):
                self.lean()
                before = self.text().count(words)
                self.driver.frames.clear()

                def spoil(message, change=change):
                    change(message)
                    return message
                self.driver.spoil = spoil
                self.wait_said(words, before + 1)
                self.wait(lambda: self.driver.force == 0.0)
                time.sleep(0.1)
                self.assertEqual(self.driver.force, 0.0)
                self.driver.spoil = lambda message: message
                self.assertEqual(self.text().count(words), before + 1, self.text())
                self.assertEqual(self.driver.frames, {"base"})

    def test_3_a_second_publisher_is_not_felt(self):
        other = subprocess.Popen(["rostopic", "pub", "-r", "50", "/omni/measured_cp", "geometry_msgs/PoseStamped",
                                  "{header: auto, pose: {position: {z: 0.3}, orientation: {w: 1.0}}}"],
                                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            self.wait_said("controls the device until it is silent for 1 s; stop one")
        finally:
            other.kill()
            other.wait()

    def name(self):
        """Palpate's, as a node."""
        _, _, state = rospy.get_master().getSystemState()
        [name] = {node for topic, nodes in state[0] for node in nodes if topic == "/omni/spatial/servo_cf"}
        return name

    def other_writer(self, topic, env=None):
        before = self.text().count("publishes wrenches for the device, too")
        other = subprocess.Popen(["rostopic", "pub", "-r", "50", topic, "geometry_msgs/WrenchStamped", "{}"],
                                 env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            self.wait_said("publishes wrenches for the device, too", before + 1)
            newest = newest_line(self.text(), "publishes wrenches for the device, too")
            self.assertRegex(newest, "'/rostopic_.*' publishes wrenches for the device, too: no force until")
        except BaseException:
            other.kill()
            raise
        return other

    def no_force(self):
        self.wait(lambda: self.forces_of_palpate() == {0.0})

    def lean_without_force(self):
        """As lean(), where the force is not to come back."""
        self.driver.height = FREE
        time.sleep(1.5)
        self.driver.height = PRESSED
        time.sleep(1.0)
        self.assertEqual(self.forces_of_palpate(), {0.0})

    def forces_of_palpate(self):
        """Those of the next wrenches, whoever else publishes some."""
        with Ear("/omni/spatial/servo_cf", WrenchStamped) as ear:
            time.sleep(0.3)
            return {m.wrench.force.z for m in ear.all if "palpate" in m._connection_header["callerid"]}

    def test_3b_another_publisher_of_wrenches_ends_the_force_until_it_has_ended(self):
        self.lean()
        other = self.other_writer("/omni/spatial/servo_cf")
        self.no_force()
        other.send_signal(signal.SIGINT)
        other.wait()
        self.lean()

    def test_3c_one_that_has_crashed_stays_registered_and_does_not_count(self):
        self.lean()
        other = self.other_writer("/omni/body/servo_cf")
        self.no_force()
        other.kill()
        other.wait()
        self.lean()

    def test_3d_one_counts_that_listens_at_its_second_address_only(self):
        self.lean()
        env = {name: value for name, value in os.environ.items() if name != "ROS_IP"}
        other = self.other_writer("/omni/spatial/servo_cf", {**env, "ROS_HOSTNAME": "localhost"})
        try:
            self.no_force()
            self.lean_without_force()
        finally:
            other.kill()
            other.wait()
        self.lean()

    def test_3e_one_that_calls_itself_localhost_may_be_on_another_host(self):
        address, topic = other_address(), "/far/body/servo_cf"
        if address is None:
            self.skipTest("this host has no address but that of the loopback")
        said = os.path.join(self.folder.name, "said_far")
        env = {name: value for name, value in os.environ.items() if name != "ROS_IP"}
        driver = Driver("/far")
        with open(said, "wb") as file:
            run = subprocess.Popen([PALPATE, "run", self.scene, "--no-gateway", "--no-index-file", "--tool", "0.02,0.02,0.02", "--device",
                                    "ros1:/far,force_max=8,rate=20"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=file,
                                   env={**env, "ROS_IP": address})
        other = None
        try:
            self.lean(driver)
            other = subprocess.Popen(["rostopic", "pub", "-r", "50", topic, "geometry_msgs/WrenchStamped", "{}"],
                                     stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env={**env, "ROS_HOSTNAME": "localhost"})

            def says_so():
                with open(said, encoding="utf-8") as file:
                    return "publishes wrenches for the device, too" in file.read()
            self.wait(says_so)
            self.wait(lambda: driver.force == 0.0)
            # From here it is as one of another host is: nobody listens here at its port.
            other.kill()
            other.wait()
            driver.height = FREE
            time.sleep(1.5)
            driver.height = PRESSED
            time.sleep(1.0)
            self.assertEqual(driver.force, 0.0)
            master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
            [name] = {node for listed, nodes in master.getSystemState("/test")[2][0] for node in nodes
                      if listed == topic and node.startswith("/rostopic")}
            master.unregisterPublisher(name, topic, master.lookupNode("/test", name)[2])  # as `rosnode cleanup` does
            self.lean(driver)
        finally:
            driver.ends = True
            for process in (run, other):
                if process is not None:
                    process.terminate()
                    process.wait(30)

    def test_4_the_master_is_killed_and_started_again(self):
        self.master.kill()
        self.wait_said("lost the ROS master")
        wrenches = self.driver.wrenches
        self.wait(lambda: self.driver.wrenches > wrenches + 20)  # connections stay
        self.master.start()
        self.wait_said("connected to the ROS master", 2)
        # A node that comes now finds it through the new master.
        found = subprocess.run(["timeout", "20", "rostopic", "echo", "-n", "1", "/omni/spatial/servo_cf"], capture_output=True,
                               text=True, check=False)
        self.assertIn("force:", found.stdout, found.stderr)

    def test_4b_a_master_that_has_restarted_need_not_know_another_publisher_of_wrenches(self):
        self.lean()
        other = self.other_writer("/omni/spatial/servo_cf")  # which, as rospy does, registers once only
        try:
            self.no_force()
            found = self.text().count("connected to the ROS master")
            self.master.kill()
            self.wait_said("lost the ROS master", found)
            self.master.start()
            self.wait_said("connected to the ROS master", found + 1)
            self.wait(lambda: any(topic == "/omni/spatial/servo_cf" for topic, _ in rospy.get_master().getSystemState()[2][0]))
            self.lean_without_force()
        finally:
            other.kill()
            other.wait()
        self.lean()

    def test_4c_what_the_master_has_lost_is_registered_again(self):
        topic = "/omni/body/servo_cf"
        name = self.name()
        master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
        self.assertEqual(master.unregisterPublisher(name, topic, master.lookupNode("/test", name)[2])[2], 1)
        self.wait(lambda: [topic, [name]] in master.getSystemState("/test")[2][0], 5.0)

    def test_5_silence_ends_the_force_and_it_comes_back(self):
        self.lean()
        self.driver.spoil = lambda message: None
        self.wait(lambda: self.driver.force == 0.0)
        self.wait_said("stale-pose")
        self.driver.spoil = lambda message: message
        self.lean()


    def test_6_a_driver_that_does_not_listen_is_told_and_feels_no_step_once_it_does(self):
        self.lean()
        self.driver.stop_listening()
        self.driver.force = 0.0
        self.wait_said("nothing subscribes to spatial/servo_cf or body/servo_cf")
        self.driver.listen()
        wrenches = self.driver.wrenches
        self.wait(lambda: self.driver.wrenches > wrenches + 200)
        self.assertEqual(self.driver.force, 0.0, "in contact, before the gate")
        self.lean()
        self.assertEqual(self.text().count("nothing subscribes"), 1)

    def test_6b_a_driver_that_subscribes_in_contact_beside_another_feels_no_step(self):
        echo = subprocess.Popen(["rostopic", "echo", "/omni/spatial/servo_cf"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            self.wait(lambda: any(topic == "/omni/spatial/servo_cf" and len(nodes) > 1
                                  for topic, nodes in rospy.get_master().getSystemState()[2][1]))
            time.sleep(1.0)
            self.lean()
            said = self.text().count("nothing subscribes")
            self.driver.stop_listening()
            time.sleep(3.0)  # longer than what it waits for a subscriber
            self.assertEqual(self.text().count("nothing subscribes"), said, "one is there all the time")
            forces, hear = [], self.driver.hear

            def note(message):
                forces.append(message.wrench.force.z)
                hear(message)
            self.driver.hear = note
            self.driver.listen()
            self.wait(lambda: len(forces) > 300)
            self.driver.hear = hear
        finally:
            echo.kill()
            echo.wait()
        print(f"forces at first: {forces[:10]}, most {max(map(abs, forces))}")
        self.assertEqual(set(forces[3:]), {0.0}, "in contact, before the gate")  # some were under way
        self.driver.stop_listening()
        self.driver.listen()
        self.lean()

    def test_9_a_node_that_is_killed_by_name_ends_with_a_zero_wrench(self):
        self.lean()
        end_by_name(self.name())
        # As a zombie, it still has an exit status for the end of this class.
        self.wait(lambda: os.waitid(os.P_PID, self.run_.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT))
        time.sleep(0.3)
        self.assertEqual(self.driver.force, 0.0)


class Refusals(unittest.TestCase):
    def test_bad_arguments_are_one_line(self):
        for text, words in {
            "ros1:": "needs the prefix of the device's topics",
            "ros1:omni": "needs the prefix",
            "ros1:/omni,force_max=nan": "'nan' is not a number",
            "ros1:/omni,force_max=0": "force_max must be positive",
            "ros1:/omni,weight=3": "there is no option 'weight'",
            "ros1:/omni,rate": "'rate' is not NAME=VALUE",
            "ros1:/omni,extrapolation=0.5": "extrapolation must be 0 to 0.01 s",
        }.items():
            with self.subTest(device=text):
                result = subprocess.run([PALPATE, "run", "--no-gateway", "--device", text, "--seconds", "1"], capture_output=True,
                                        text=True, check=False)
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertIn(words, result.stderr)
                self.assertEqual(result.stderr.count("\n"), 1, result.stderr)

    def test_a_hand_without_a_device_of_its_own_is_refused(self):
        result = subprocess.run([PALPATE, "run", "--no-gateway", "--device", "ros1:/omni,rate=20", "--hands", "left", "--seconds", "1"],
                                env={**os.environ, "ROS_MASTER_URI": f"http://127.0.0.1:{free_port()}"}, capture_output=True,
                                text=True, check=False, timeout=60)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, "hand left: .*device 'ros1:/omni': another hand of this program uses it")


if __name__ == "__main__":
    unittest.main()
