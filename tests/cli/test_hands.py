"""Several hands over one scene: topics, services, parameters and recordings a hand, by a real client."""

import json
import os
import re
import select
import signal
import time
import unittest

from support import columns_of, head_of, path_csv
from test_gateway import PATIENCE, Gateway
from test_run import Live


class Hands(Gateway):
    """A first hand and one called left, whose tool is a small ball; each waits above the wall."""

    def setUp(self):
        super().setUp()
        self.write("left.toml", "tool = [0.01, 0.01, 0.01]\nstiffness = 321\n")

    def start(self, *more, hands="left=left.toml", **how):
        super().start("--hands", hands, *more, **how)

    def message_of(self, topic):
        """The next message of a topic."""
        send, receive = self.socket()
        send({"op": "subscribe", "topic": topic})
        while (message := json.loads(receive()[1])).get("topic") != topic:
            pass
        return message["msg"]

    def of(self, call, hand):
        return json.loads(call(f"/palpate/{hand}get_parameters")["message"])

    def state(self, hand):
        status = self.message_of(f"/palpate/{hand}diagnostics")["status"][0]
        values = {value["key"]: value["value"] for value in status["values"]}
        return status["name"], values["fault"]


class Topics(Hands):
    def test_each_has_its_own(self):
        self.start()
        axes = {hand: self.message_of(f"/palpate/{hand}tool")["markers"][0]["scale"]["z"] for hand in ("", "left/")}
        self.assertEqual(axes, {"": 0.08, "left/": 0.02})
        self.assertEqual(self.state("")[0], "palpate: servo")
        self.assertEqual(self.state("left/")[0], "palpate/left: servo")
        call = self.client()
        both = {hand: {topic.removeprefix(f"/palpate/{hand}") for topic in call("/rosapi/topics")["topics"]
                       if topic.startswith(f"/palpate/{hand}")} for hand in ("", "left/")}
        self.assertEqual({topic for topic in both[""] if not topic.startswith("left/")} - both["left/"], {"hands", "messages"})
        self.end()

    def test_all_tools_in_one(self):
        self.start(hands="left=left.toml,right")
        markers = self.message_of("/palpate/hands")["markers"]
        sizes = {marker["ns"]: marker["scale"]["x"] for marker in markers if not marker["ns"].endswith("/force")}
        self.assertEqual(sizes, {"": 0.04, "left": 0.02, "right": 0.04})
        self.assertEqual({marker["ns"] for marker in markers if marker["ns"].endswith("/force")}, {"/force", "left/force", "right/force"})
        self.end()

    def test_names_that_are_taken(self):
        """Whatever the first hand has cannot be the name of another."""
        self.start()
        call = self.client()
        names = [name for what in ("topics", "services") for name in call(f"/rosapi/{what}")[what]]
        names += call("/rosapi/get_param_names")["names"]
        taken = {name.split("/")[2] for name in names if name.startswith("/palpate/")} - {"left"}
        self.end()
        self.assertIn("client", taken)
        for name in sorted(taken):
            self.refuse(1, [f"'{name}'", f"/palpate/{name}"], "run", "wall.ply", "--hands", name)


class Services(Hands):
    def test_parameters(self):
        self.start()
        call = self.client()
        first, left = self.of(call, ""), self.of(call, "left/")
        self.assertEqual((first["hand"], first["hands"], left["hand"], left["hands"]), ("", ["left"], "left", ["left"]))
        self.assertEqual((first["stiffness"], left["stiffness"]), (500, 321))
        self.assertEqual(first["scene"], left["scene"])
        answer = call("/palpate/left/set_parameters", json=json.dumps({"stiffness": 100}))
        self.assertTrue(answer["success"], answer)
        self.until(lambda: self.of(call, "left/")["stiffness"] == 100)
        self.assertEqual(self.of(call, "")["stiffness"], 500)
        answer = call("/palpate/left/set_parameters", json=json.dumps({"filter": {"opacity_min": 0.9}}))
        self.assertFalse(answer["success"])
        self.assertIn("first hand", answer["message"])
        self.assertEqual(call("/rosapi/get_param", name="/palpate/left/stiffness", default="")["value"], "100.0")
        call("/rosapi/set_param", name="/palpate/left/stiffness", value="150")
        self.until(lambda: self.of(call, "left/")["stiffness"] == 150)
        # What it answers starts the next run's hand as it is now.
        self.write("again.toml", call("/palpate/left/config")["message"])
        self.end()
        self.start(hands="left=again.toml")
        call = self.client()
        self.assertEqual(self.of(call, "left/")["stiffness"], 150)
        self.assertEqual(self.of(call, "left/")["tool"][0]["semi_axes"], [0.01, 0.01, 0.01])
        self.end()

    def test_a_parameter_that_a_named_hand_refuses_ends_nothing(self):
        self.start()
        send, receive = self.socket()
        for name, value in (("filter", {"opacity_min": 0.9}), ("registration", {"scale": 2})):
            send({"op": "call_service", "service": "/rosapi/set_param",
                  "args": {"name": f"/palpate/left/{name}", "value": json.dumps(value)}})
            answer = json.loads(receive()[1])
            self.assertIs(answer["result"], False, answer)
            self.assertIn("first hand", answer["values"])
        self.assertEqual(self.of(self.client(), "left/")["filter"]["opacity_min"], 0.1)
        self.end()

    def test_the_scene_of_the_first_is_followed(self):
        self.start()
        call = self.client()
        answer = call("/palpate/set_parameters", json=json.dumps({"filter": {"opacity_min": 0.3}}))
        self.assertTrue(answer["success"], answer)
        self.until(lambda: self.of(call, "left/")["filter"]["opacity_min"] == 0.3)
        self.assertEqual(self.of(call, "left/")["message"], "")
        self.end()

    def test_a_stop_of_one_and_of_all(self):
        self.start(hands="left=left.toml,right")
        call = self.client()
        self.assertTrue(call("/palpate/left/emergency_stop")["success"])
        self.until(lambda: self.state("left/")[1] == "emergency-stop")
        for hand in ("", "right/"):
            self.assertNotEqual(self.state(hand)[1], "emergency-stop")
        self.assertTrue(call("/palpate/emergency_stop")["success"])
        for hand in ("", "left/", "right/"):
            self.until(lambda hand=hand: self.state(hand)[1] == "emergency-stop")
        # Each goes on by itself.
        self.assertTrue(call("/palpate/resume")["success"])
        self.until(lambda: self.state("")[1] != "emergency-stop")
        self.assertEqual(self.state("left/")[1], "emergency-stop")
        self.end()

    def test_recordings(self):
        self.start()
        call = self.client()
        self.assertTrue(call("/palpate/left/record", data=True)["success"])
        time.sleep(0.3)
        self.assertTrue(call("/palpate/left/record", data=False)["success"])
        self.assertEqual(self.ask("/recording")[0], 404)
        status, _, body = self.ask("/hands/left/recording")
        self.assertEqual(status, 200)
        self.assertIn("tool = [0.01, 0.01, 0.01]", head_of(body))
        self.until(lambda: self.ask("/hands/left/recording.html")[0] == 200)
        self.assertEqual(self.ask("/hands/right/recording")[0], 404)
        self.end()

    def test_metrics_and_health(self):
        self.start()
        self.until(lambda: self.ask("/healthz")[2] == b"ok\n")
        text = self.ask("/metrics")[2].decode()
        for name in ("palpate_ticks_total", "palpate_force_newtons", "palpate_tick_seconds_count"):
            self.assertRegex(text, rf"(?m)^{name} [0-9.e+-]+$")
            self.assertRegex(text, rf'(?m)^{name}{{hand="left"}} [0-9.e+-]+$')
        self.assertRegex(text, r'(?m)^palpate_tick_seconds{hand="left",quantile="0.99"} ')
        self.assertEqual(text.count("# TYPE palpate_ticks_total "), 1)
        self.end()


class Clients(Hands):
    def hold(self, hand, x):
        """A client that leads a hand: a function that sends one pose."""
        send, _ = self.socket()
        pose = {"position": {"x": x, "y": 0, "z": 0.1}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}
        message = {"header": {"frame_id": "world", "stamp": {"secs": 0, "nsecs": 0}}, "pose": pose}
        return lambda: send({"op": "publish", "topic": f"/palpate/{hand}client/measured_cp", "msg": message})

    def test_each_hand_has_its_client_and_loses_it_alone(self):
        self.write("client.toml", 'device = "client"\n')
        self.start("--device", "client", hands="left=client.toml")
        poses = [self.hold("", 0.01), self.hold("left/", -0.02)]

        def place(hand):
            for pose in poses:
                pose()
            return self.message_of(f"/palpate/{hand}measured_cp")["pose"]["position"]["x"]

        self.until(lambda: place("") == 0.01 and place("left/") == -0.02)
        del poses[1]  # it vanishes
        self.until(lambda: place("") == 0.01 and self.state("left/")[1] == "stale-pose")
        self.assertEqual(place(""), 0.01)
        self.assertNotEqual(self.state("")[1], "emergency-stop")
        self.end()


class Runs(Hands):
    def test_summary_and_recordings(self):
        document = self.succeed("run", "wall.ply", "--trajectory", "hand.csv", "--hands", "left=left.toml", "--seconds", "1",
                                "--no-gateway", "--record", "run.csv", "--json").json
        self.assertEqual(list(document["hands"]), ["left"])
        left = document["hands"]["left"]
        self.assertGreater(left["ticks"], 0)
        self.assertEqual(set(left), set(document) - {"hands"})
        tools = [hand["made"]["settings"]["tool"] for hand in (left, document)]
        self.assertEqual(tools, [[0.01, 0.01, 0.01], [0.02, 0.02, 0.04]])
        for name, tool in (("run.csv", "0.02, 0.02, 0.04"), ("run-left.csv", "0.01, 0.01, 0.01")):
            self.assertIn(f"tool = [{tool}]", head_of(self.read(name)))
            self.assertGreater(len(columns_of(self.read(name))["t"]), 100)

    def test_a_recording_that_exists_leaves_none_of_the_others(self):
        self.write("run-left.csv", "mine")
        self.refuse(1, "run-left.csv", "run", "wall.ply", "--trajectory", "hand.csv", "--hands", "left=left.toml",
                    "--record", "run.csv", "--seconds", "1", "--no-gateway")
        self.assertFalse(os.path.exists(self.path("run.csv")))
        self.assertEqual(self.read("run-left.csv"), b"mine")

    def test_what_cannot_be(self):
        self.write("bad.toml", "friction = 0.1\nopacity-min = 0.2\n")
        self.write("spoon.toml", 'device = "playback"\n')
        self.write("gone.toml", 'device = "plugin:/nowhere.so"\n')
        for hands, words in (("Left", "'Left'"), ("tool", "/palpate/tool"), ("left,left", "two hands"), ("left=nowhere.toml", "nowhere.toml"),
                             ("left=bad.toml", "bad.toml: line 2: 'opacity-min'"), ("left=gone.toml", ["hand left", "/nowhere.so"])):
            self.refuse(1, words, "run", "wall.ply", "--hands", hands, "--no-gateway", "-q")

    def test_a_signal_ends_all(self):
        self.start(hands="left=left.toml,right")
        self.process.send_signal(signal.SIGUSR1)
        for hand in ("", "left/", "right/"):
            self.until(lambda hand=hand: self.state(hand)[1] == "emergency-stop")
        document = self.end()
        self.assertIn("emergency-stop", document["hands"]["right"]["faults"])


class Touch(Hands):
    """Far from the wall a hand comes at the first, which stays where it is but for a drift that no device of hardware is without."""

    def forces(self, *more):
        ball = "tool = [0.01, 0.01, 0.01]\n"
        times = [k / 20 for k in range(61)]
        self.write("first.csv", path_csv([(t, 0.0, 1e-4 * t, 1.0) for t in times]))
        self.write("left.csv", path_csv([(t, max(0.018, 0.05 - 0.02 * t), 1e-4 * t, 1.0) for t in times]))
        self.write("first.toml", ball)
        self.write("other.toml", ball + 'trajectory = "left.csv"\n')
        self.succeed("run", "wall.ply", "--config", "first.toml", "--device", "playback", "--trajectory", "first.csv", "--seconds", "3",
                     "--hands", "left=other.toml", "--record", "run.csv", "--no-gateway", "-q", *more)
        runs = [columns_of(self.read(name)) for name in ("run.csv", "run-left.csv")]
        for name in ("run.csv", "run-left.csv"):
            os.remove(self.path(name))
        return [[float(f) for f in run["fx"]] for run in runs]

    def test_hands_feel_each_other_where_that_is_asked_for(self):
        first, left = self.forces("--hands-touch")
        self.assertGreater(max(left), 0.3)
        self.assertAlmostEqual(-min(first), max(left), delta=0.02 * max(left))
        self.assertLessEqual(max(first), 0.0)
        self.assertGreaterEqual(min(left), 0.0)

    def test_else_they_do_not(self):
        for forces in self.forces():
            self.assertEqual(set(forces), {0.0})


class Terminal(Live):
    def test_a_line_a_hand_and_keys_for_all(self):
        leader, process = self.on_a_terminal("--hands", "left,right", "--no-gateway")
        shown = b""

        def shows(pattern):
            nonlocal shown
            until = time.monotonic() + PATIENCE
            while not re.search(pattern, shown) and time.monotonic() < until:
                if select.select([leader], [], [], 0.1)[0]:
                    shown = shown[-8192:] + os.read(leader, 65536)
            self.assertTrue(re.search(pattern, shown), (pattern, shown[-500:]))

        shows(rb" N/m [^\n]*\n\r[^\n]* s  hand left: [^\n]*\n\r[^\n]* s  hand right: ")
        os.write(leader, b"e")
        stopped = rb"stopped \(emergency-stop\)"
        shows(rb" s  " + stopped + rb"[^\n]*\n\r[^\n]* s  hand left: " + stopped + rb"[^\n]*\n\r[^\n]* s  hand right: " + stopped)
        os.write(leader, b"q")
        document = json.loads(process.communicate(timeout=PATIENCE)[0])
        self.assertEqual(process.returncode, 0)
        self.assertIn("emergency-stop", document["hands"]["left"]["faults"])


if __name__ == "__main__":
    unittest.main()
