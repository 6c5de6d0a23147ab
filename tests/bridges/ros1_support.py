"""A real roscore, and a driver of a haptic device that is an ordinary rospy node, for the tests of the bridge to ROS 1."""

import faulthandler
import os
import signal
import socket
import subprocess
import threading
import time
import xmlrpc.client

import rospy
from geometry_msgs.msg import PoseStamped, WrenchStamped
from std_msgs.msg import Header

FREE, PRESSED = 0.05, 0.016  # heights of a ball of 2 cm over the wall. Unit: [m]


def too_late(*_):
    faulthandler.dump_traceback()
    raise TimeoutError("these tests take too long; above is where each thread was")


# Before the 300 s after which CTest would end them without a word, and leave their programs behind.
signal.signal(signal.SIGALRM, too_late)
signal.alarm(240)


def newest_line(text, words):
    """The last line of `text` with those words; others may have been said since."""
    return [line for line in text.splitlines() if words in line][-1]


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Master:
    """A roscore's master, which may be killed and started again on the same port."""

    def __init__(self, port):
        self.port = port
        self.start()

    def start(self):
        self.process = subprocess.Popen(["rosmaster", "--core", "-p", str(self.port)], stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)
        deadline = time.time() + 20
        while time.time() < deadline:
            try:
                socket.create_connection(("127.0.0.1", self.port), 1).close()
                return
            except OSError:
                time.sleep(0.05)
        raise RuntimeError("no rosmaster")

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()


def end_by_name(name):
    """What `rosnode kill` does."""
    _, _, uri = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]).lookupNode("/test", name)
    xmlrpc.client.ServerProxy(uri).shutdown("/test", "by the test")


class Ear:
    """The messages of a topic, newest last, as long as a test listens: Python is slow."""

    def __init__(self, topic, kind):
        self.all = []
        self.subscriber = rospy.Subscriber(topic, kind, self.all.append)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.subscriber.unregister()


class Driver:
    """What speaks CRTK: poses with stamps, wrenches back."""

    def __init__(self, prefix="/omni", rate=1000):
        self.period = 1.0 / rate
        self.height, self.at = FREE, FREE
        self.force, self.wrenches, self.body = 0.0, 0, 0
        self.sent, self.round_trips, self.frames = 0, [], set()
        self.spoil = lambda message: message
        self.ends = False
        self.publisher = rospy.Publisher(prefix + "/measured_cp", PoseStamped, queue_size=4, tcp_nodelay=True)
        self.echoed = rospy.Publisher(prefix + "/palpate/echoed", Header, queue_size=4, tcp_nodelay=True)
        rospy.Subscriber(prefix + "/palpate/echo", Header, self.answer, tcp_nodelay=True)
        self.prefix, self.listeners = prefix, []
        self.listen()
        self.times = {}
        threading.Thread(target=self.speak, daemon=True).start()

    def listen(self):
        self.listeners = [rospy.Subscriber(self.prefix + "/spatial/servo_cf", WrenchStamped, self.hear, tcp_nodelay=True),
                          rospy.Subscriber(self.prefix + "/body/servo_cf", WrenchStamped, self.hear_body, tcp_nodelay=True)]

    def stop_listening(self):
        for listener in self.listeners:
            listener.unregister()

    def answer(self, echo):
        self.echoed.publish(Header(seq=echo.seq, stamp=rospy.Time.now(), frame_id=""))

    def hear(self, message):
        self.force = message.wrench.force.z
        self.frames.add(message.header.frame_id)
        self.wrenches += 1
        sent = self.times.pop(message.header.stamp.to_nsec() // 1000, None)
        if sent is not None:
            self.round_trips.append(time.perf_counter() - sent)

    def hear_body(self, message):
        self.body += 1
        self.body_frame = message.header.frame_id

    def speak(self):
        message = PoseStamped()
        message.header.frame_id = "base"
        due = time.perf_counter()
        while not self.ends:
            step = 0.1 * self.period  # 0.1 m/s
            self.at += max(-step, min(step, self.height - self.at))
            message.header.stamp = rospy.Time.from_sec(round(time.time(), 6))
            message.pose.position.x = message.pose.position.y = 0.0
            message.pose.position.z = self.at
            message.pose.orientation.x = message.pose.orientation.y = message.pose.orientation.z = 0.0
            message.pose.orientation.w = 1.0
            out = self.spoil(message)
            if out is not None:
                self.times[message.header.stamp.to_nsec() // 1000] = time.perf_counter()
                self.publisher.publish(out)
                self.sent += 1
            message.header.frame_id = "base"
            due = max(due + self.period, time.perf_counter() - 0.005)
            time.sleep(max(0.0, due - time.perf_counter()))
