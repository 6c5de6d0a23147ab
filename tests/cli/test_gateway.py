"""The gateway of palpate run over plain sockets: who is refused, and that nothing a client does reaches the loop."""

import base64
import json
import os
import pathlib
import re
import resource
import signal
import socket
import struct
import subprocess
import tempfile
import threading
import time
import unittest

from support import PALPATE, SANITIZED, Case, path_csv, ply, stood_still, table_of, threads_of, wall_rows
from test_run import press_path

PATIENCE = 60 if SANITIZED else 20
KEY = base64.b64encode(b"0123456789abcdef").decode()
TOKEN = "s3cret_s3cret_s3cret"
EVERY_TOPIC = ("measured_cp", "measured_cv", "spatial/servo_cf", "body/servo_cf", "proxy_cp", "contacts", "tool", "diagnostics",
               "parameters", "client/servo_cf")
SLOW_DISK = os.environ.get("SLOW_DISK_LIBRARY")
STUCK_DISK = os.environ.get("STUCK_DISK_LIBRARY")


class Gateway(Case):
    def setUp(self):
        super().setUp()
        self.write("wall.ply", ply(wall_rows()))
        self.write("hand.csv", path_csv([(0.0, 0.0, 0.0, 0.05), (60.0, 0.0, 0.0, 0.05)]))

    def start(self, *more, hand=("--trajectory", "hand.csv"), **how):
        """A run whose port and token are then self.port and self.token."""
        self.process = subprocess.Popen(
            [PALPATE, "run", "wall.ply", *hand, "--port", "0", "--json", *more], cwd=self.folder,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **how)
        self.addCleanup(lambda: self.process.poll() is None and self.process.kill())
        said = b""
        while not (found := re.search(rb"http://[\w.-]+:(\d+)/(?:\?token=(\w+))?\n", said)):
            line = self.process.stderr.readline()
            self.assertTrue(line, said)
            said += line
        self.port, self.token = int(found[1]), (found[2] or b"").decode()

    def end(self):
        self.process.terminate()
        out = self.process.communicate(timeout=PATIENCE)[0]
        self.assertEqual(self.process.returncode, 0)
        return json.loads(out)

    def connect(self):
        connection = socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE)
        self.addCleanup(connection.close)
        return connection

    def ask(self, target="/", method="GET", host=None, **headers):
        """Status, headers and body of one request."""
        lines = [f"{method} {target} HTTP/1.1", f"Host: {host or f'127.0.0.1:{self.port}'}", "Connection: close"]
        lines += [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
        connection = self.connect()
        connection.sendall("\r\n".join([*lines, "", ""]).encode())
        answer = b""
        while part := connection.recv(65536):
            answer += part
        head, _, body = answer.partition(b"\r\n\r\n")
        return int(head.split()[1]), head.decode().lower(), body

    def upgrade(self, **headers):
        return self.ask(Upgrade="websocket", Sec_WebSocket_Version="13", Sec_WebSocket_Key=KEY, **headers)[0]

    def socket(self, proof=None):
        """A WebSocket, as a pair of functions: send a text, and receive one."""
        connection = self.connect()
        proof = proof or (f"Authorization: Bearer {self.token}\r\n" if self.token else "")
        connection.sendall((f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
                            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {KEY}\r\n{proof}\r\n").encode())
        stream = connection.makefile("rb")
        self.assertIn(b" 101 ", stream.readline())
        while stream.readline().strip():
            pass

        def send(message, opcode=1):
            data = message if isinstance(message, bytes) else json.dumps(message).encode()
            length = bytes([0x80 | len(data)]) if len(data) < 126 else b"\xfe" + struct.pack(">H", len(data))
            connection.sendall(bytes([0x80 | opcode]) + length + bytes(4) + data)  # a mask of zeros

        def receive():
            opcode, length = stream.read(2)
            if opcode & 15 == 9:  # a ping, of a server that has heard nothing for a while
                send(stream.read(length), opcode=10)
                return receive()
            length = {126: lambda: struct.unpack(">H", stream.read(2))[0],
                      127: lambda: struct.unpack(">Q", stream.read(8))[0]}.get(length, lambda: length)()
            return opcode & 15, stream.read(length)

        return send, receive

    def client(self):
        """A function that calls a service and gives what it answers."""
        send, receive = self.socket()

        def call(service, **arguments):
            send({"op": "call_service", "service": service, "args": arguments})
            while (answer := json.loads(receive()[1])).get("service") != service:
                pass
            return answer["values"]

        return call

    def parameters(self, call):
        return json.loads(call("/palpate/get_parameters")["message"])

    def until(self, condition):
        for _ in range(10 * PATIENCE):
            if condition():
                return
            time.sleep(0.1)
        self.fail("it never came to that")


class Refused(Gateway):
    def test_hosts_origins_and_paths(self):
        self.start()
        own = f"127.0.0.1:{self.port}"
        self.assertEqual(self.ask()[0], 200)
        self.assertEqual(self.ask(host=f"localhost:{self.port}")[0], 200)
        for host in ("evil.example", f"evil.example:{self.port}", "127.0.0.1", "127.0.0.1:1", f"127.0.0.1.evil.example:{self.port}"):
            self.assertEqual(self.ask(host=host)[0], 403, host)
        for origin in ("http://evil.example", "null", "http://127.0.0.1:1", f"http://evil.example:{self.port}", "file://"):
            self.assertEqual(self.ask(Origin=origin)[0], 403, origin)
            self.assertEqual(self.upgrade(Origin=origin), 403, origin)
        self.assertEqual(self.ask(Origin=f"http://{own}")[0], 200)
        for path in ("/../wall.ply", "/..%2fwall.ply", "/%2e%2e/wall.ply", "/scene/../../etc/passwd", "/\\..\\wall.ply",
                     "//etc/passwd", "/wall.ply", "/etc/passwd", "/%", "/%zz", "/a%00b", "http://evil.example/"):
            status, _, body = self.ask(path)
            self.assertIn(status, (400, 404), path)
            self.assertNotIn(b"root:", body)
        for method in ("POST", "PUT", "DELETE", "OPTIONS", "CONNECT", "TRACE"):
            self.assertIn(self.ask("/", method)[0], (400, 405), method)
        self.end()

    def test_a_page_of_another_origin_is_named_on_the_terminal(self):
        self.start()
        send, receive = self.socket()
        send({"op": "subscribe", "topic": "/palpate/messages"})
        for _ in range(3):
            self.assertEqual(self.upgrade(Origin="http://localhost:5173"), 403)
        lines = []
        while not any("5173" in line for line in lines):
            lines = json.loads(json.loads(receive()[1])["msg"]["data"])
        self.process.terminate()
        err = self.process.communicate(timeout=PATIENCE)[1].decode()
        self.assertEqual(err.count("http://localhost:5173;"), 1, err)

    def test_without_the_token_when_it_listens_to_others(self):
        self.start("--listen", "127.0.0.1", "--token", TOKEN)
        self.assertEqual(self.token, TOKEN)
        for headers in ({}, {"Authorization": f"Bearer {TOKEN[:-1]}"}, {"Authorization": f"Basic {TOKEN}"}, {"Cookie": "palpate=x"}):
            self.assertEqual(self.ask(**headers)[0], 401, headers)
        self.assertEqual(self.upgrade(), 401)
        self.assertEqual(self.ask(f"/?token={TOKEN}2")[0], 401)
        # The page is then without the token in its address; whatever else comes with it gets what it asks for.
        status, head, _ = self.ask(f"/?x=1&token={TOKEN}")
        self.assertEqual(status, 303)
        self.assertIn("location: /?x=1\r\n", head)
        self.assertIn("httponly", head)
        self.assertNotIn(TOKEN, head)
        cookie = re.search(rf"set-cookie: (palpate-{self.port}=\w+);", head)[1]
        self.assertEqual(self.ask("/?x=1", Cookie=f"a=b; {cookie}")[0], 200)
        self.assertEqual(self.ask("/scene", Cookie=cookie)[0], 200)
        self.socket(f"Cookie: {cookie}\r\n")
        self.assertEqual(self.ask("/scene", Authorization=f"Bearer {TOKEN}")[0], 200)
        self.assertEqual(self.ask(f"/scene?token={TOKEN}")[0], 200)
        # After too many wrong ones none is taken, but who is in is in.
        for _ in range(10):
            status = self.ask("/?token=wrong")[0]
        self.assertEqual(status, 429)
        self.assertEqual(self.ask(f"/scene?token={TOKEN}")[0], 429)
        self.socket(f"Cookie: {cookie}\r\n")
        self.end()

    def test_tokens_that_are_too_weak(self):
        for token in ("", "s3cret", "a" * 15, "a" * 300, "s3cret s3cret s3cret", "s3cret&s3cret&s3cret", "s3cret;s3cret;s3cret"):
            self.refuse(2, ["--token", "16"], "run", "wall.ply", "--seconds", "1", "--token", token)

    def test_addresses_that_it_cannot_have(self):
        for options in (["--listen", "nowhere"], ["--listen", "203.0.113.1"], ["--port", "70000"]):
            result = self.run_palpate("run", "wall.ply", "--trajectory", "hand.csv", "--seconds", "1", *options)
            self.assertIn(result.code, (1, 2), options)
            self.assertEqual(len(result.err.splitlines()), 1 if result.code == 1 else len(result.err.splitlines()))
        self.start()
        result = self.run_palpate("run", "wall.ply", "--trajectory", "hand.csv", "--seconds", "1", "--port", str(self.port))
        self.assertEqual(result.code, 1)
        self.assertIn(b"--port", result.err)
        self.end()

    def test_other_machines_get_a_token_by_themselves(self):
        self.start("--listen", "0.0.0.0")
        self.assertRegex(self.token, r"\A[0-9a-f]{32}\Z")
        self.assertEqual(self.ask()[0], 401)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.connect(("192.0.2.1", 9))  # nobody's: chooses the interface of the default route, sends nothing
            except OSError:
                self.skipTest("no network")
            own = probe.getsockname()[0]
        self.assertIn(f" http://{own}:{self.port}/?token={self.token}\n", self.process.stderr.readline().decode())
        self.assertEqual(self.ask(f"/?token={self.token}", host=f"{own}:{self.port}")[0], 303)
        self.end()

    def test_an_address_of_another_machine(self):
        for port in ((), ("--port", "0"), ("--port", "9090")):
            result = self.refuse(1, ["cannot listen on 192.0.2.1: ", "--listen", "0.0.0.0"], "run", "wall.ply", "--seconds", "1",
                                 "--trajectory", "hand.csv", "--listen", "192.0.2.1", *port)
            self.assertNotIn(b"port", result.err)


class Served(Gateway):
    def test_the_scene_is_the_file_in_parts_too(self):
        self.start()
        whole = self.read("wall.ply")
        status, head, body = self.ask("/scene")
        self.assertEqual((status, body), (200, whole))
        tag = re.search(r'etag: ("[^"]+")', head)[1]
        self.assertEqual(self.ask("/scene", Range="bytes=10-19")[::2], (206, whole[10:20]))
        self.assertEqual(self.ask("/scene", Range="bytes=-7")[::2], (206, whole[-7:]))
        self.assertEqual(self.ask("/scene", Range=f"bytes={len(whole)}-")[0], 416)
        self.assertEqual(self.ask("/scene", If_None_Match=tag)[::2], (304, b""))
        self.end()

    def test_a_scene_that_the_viewer_cannot_read_is_served_as_one_that_it_can(self):
        rows = wall_rows()
        for kind in ("ascii", "binary_big_endian"):
            with self.subTest(kind):
                self.write("wall.ply", ply(rows, encoding=kind))
                self.start()
                status, head, body = self.ask("/scene")
                self.assertTrue(status == 200 or "retry-after: 1" in head, head)
                self.until(lambda: self.ask("/scene")[0] == 200)
                status, head, body = self.ask("/scene")
                self.assertTrue(body.startswith(b"ply\nformat binary_little_endian 1.0\nelement vertex 441\n"))
                self.assertEqual(len(body), body.index(b"end_header\n") + 11 + 441 * 4 * 14)
                tag = re.search(r'etag: ("[^"]+")', head)[1]
                self.assertEqual(self.ask("/scene", If_None_Match=tag)[0], 304)
                self.assertEqual(self.ask("/scene", Range="bytes=0-2")[2], b"ply")
                self.end()
        self.assertEqual([name for name in os.listdir(tempfile.gettempdir()) if name.startswith("palpate-drawn-")], [])

    def test_pages_may_load_nothing_from_elsewhere(self):
        self.start()
        _, head, body = self.ask("/")
        self.assertIn("content-security-policy: default-src 'none'", head)
        self.assertIn("frame-ancestors 'none'", head)
        self.assertNotRegex(body, rb'(?:src|href)="?https?:')
        self.end()

    def test_health_and_metrics(self):
        self.start()
        self.assertEqual(self.ask("/healthz")[::2], (200, b"ok\n"))
        status, head, body = self.ask("/metrics")
        self.assertEqual(status, 200)
        self.assertIn("version=0.0.4", head)
        for line in body.decode().splitlines():
            self.assertRegex(line, r'\A(# (HELP|TYPE) palpate_\w+ .+|palpate_\w+(\{quantile="0\.\d+"\})? -?[\d.e+-]+)\Z')
        self.end()


class Changed(Gateway):
    """What happens to the scene's file while it is open."""

    def said(self, words):
        """The next line on the terminal that has these words."""
        while words not in (line := self.process.stderr.readline().decode()):
            self.assertTrue(line, f"it never said {words!r}")

    def test_another_file_of_that_name_is_noticed_and_the_old_one_drawn(self):
        self.start()
        call, old = self.client(), self.read("wall.ply")
        self.assertEqual(self.parameters(call)["message"], "")
        self.write("new.ply", ply(wall_rows(5)))
        os.rename(self.path("new.ply"), self.path("wall.ply"))
        self.until(lambda: "has been replaced" in self.parameters(call)["message"])
        self.said("has been replaced")
        self.assertEqual(self.ask("/scene")[::2], (200, old))
        self.assertEqual(self.ask("/healthz")[0], 200)
        self.end()

    def test_a_file_that_is_cut_kills_nobody(self):
        rows = wall_rows(501)  # 17 MB: more than one page of memory, and more than sockets keep
        self.write("wall.ply", ply(rows))
        self.start()
        call, whole = self.client(), len(self.read("wall.ply"))
        half = self.connect()  # has begun to load it
        half.sendall(f"GET /scene HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\n\r\n".encode())
        got = len(half.recv(4096))
        os.truncate(self.path("wall.ply"), 5000)
        self.assertEqual(self.ask("/scene")[0], 503)
        while part := half.recv(65536):
            got += len(part)
        self.assertLess(got, whole, "the connection has ended before the end")
        self.until(lambda: "has been overwritten" in self.parameters(call)["message"])
        self.said("has been overwritten")
        self.assertEqual(self.ask("/healthz")[0], 200)
        self.end()


class Placed(Gateway):
    """Whether a page may scale and turn a scene of unknown scale by itself: `assumed` says so."""

    def assumed(self, call):
        return self.parameters(call)["registration"]["assumed"]

    def place(self, call, **registration):
        return call("/palpate/set_parameters", json=json.dumps({"registration": registration}))

    def test_it_may_where_nothing_is_in_world_coordinates(self):
        self.start(hand=())
        self.assertEqual(self.assumed(self.client()), ["scale", "frame"])
        self.end()

    def test_it_may_not_where_something_is(self):
        self.write("wood.toml", '[[region]]\nstiffness = 100\nbox = { min = [-1, -1, -1], max = [1, 1, 1] }\n')
        for options in (("--trajectory", "hand.csv"), ("--crop-box=-1,-1,-1,1,1,1",), ("--crop-sphere", "0,0,0,1"), ("--max-scale", "1"),
                        ("--workspace-offset", "0,0,0.1"), ("--materials", "wood.toml"), ("--record", "run.csv")):
            with self.subTest(options):
                self.start(hand=options)
                self.assertEqual(self.assumed(self.client()), [])
                self.end()

    def test_it_may_not_while_a_client_holds_the_tool(self):
        self.start(hand=())
        call = self.client()
        send, _ = self.socket()
        pose = {"header": {"frame_id": "world"}, "pose": {"position": {"x": 0, "y": 0, "z": 0.1}, "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}}

        def assumed_while_held():
            send({"op": "publish", "topic": "/palpate/client/measured_cp", "msg": pose})
            return self.assumed(call)

        self.until(lambda: assumed_while_held() == [])
        self.until(lambda: self.assumed(call) == ["scale", "frame"])
        self.end()

    def test_a_scene_stays_where_a_recording_states_it_to_be(self):
        self.start(hand=())
        call = self.client()
        self.assertTrue(self.place(call, scale=2)["success"])
        self.until(lambda: call("/palpate/record", data=True)["success"])
        for change in ({"scale": 3}, {"frame": "y-down"}, {"mirrored": True}, {"translation": [1, 0, 0]}):
            refused = self.place(call, **change)
            self.assertFalse(refused["success"])
            self.assertIn("stop the recording", refused["message"])
        self.assertTrue(self.place(call, scale=2)["success"], "it is there")
        self.assertTrue(call("/palpate/set_parameters", json='{"stiffness": 600}')["success"])
        self.assertTrue(call("/palpate/record", data=False)["success"])
        self.assertIn(b"\n# scale = 2\n", self.ask("/recording")[2])
        self.assertTrue(self.place(call, scale=3)["success"])
        self.end()

    def test_nor_is_it_moved_in_a_run_that_is_recorded(self):
        self.start("--record", "run.csv")
        call = self.client()
        refused = self.place(call, scale=3)
        self.assertFalse(refused["success"])
        self.assertIn("--record", refused["message"])
        self.assertEqual(self.parameters(call)["registration"]["scale"], 1)
        self.end()


class Recorded(Gateway):
    def real_time_threads(self):
        return [thread for thread in threads_of(self.process.pid) if os.sched_getscheduler(thread) != os.SCHED_OTHER]

    @unittest.skipUnless(SLOW_DISK, "not with a sanitizer, or not started by ctest")
    def test_an_emergency_stop_is_heard_while_a_recording_ends(self):
        self.start(env={**os.environ, "LD_PRELOAD": SLOW_DISK})
        send, receive = self.socket()
        call = self.client()
        before = self.real_time_threads()
        self.assertTrue(call("/palpate/record", data=True)["success"])
        self.assertEqual(self.real_time_threads(), before, "writing files is nothing that must be in time")
        self.assertFalse(call("/palpate/record", data=True)["success"])
        time.sleep(0.5)
        begun = time.monotonic()
        send({"op": "call_service", "service": "/palpate/record", "args": {"data": False}})
        self.until(lambda: not self.parameters(call)["recording"])
        self.assertFalse(call("/palpate/record", data=False)["success"], "that is being done")
        self.assertTrue(call("/palpate/emergency_stop")["success"])
        self.assertEqual(self.ask("/recording")[0], 404)
        heard = time.monotonic() - begun
        self.assertTrue(json.loads(receive()[1])["values"]["success"])
        ended = time.monotonic() - begun
        self.assertGreater(ended, 2.9)
        self.assertLess(heard, ended - 0.5)  # a slow machine answers in a second or two
        self.assertEqual(self.ask("/recording")[0], 200)
        self.assertIn("emergency-stop", self.end()["faults"])

    @unittest.skipUnless(STUCK_DISK, "not with a sanitizer, or not started by ctest")
    def test_ticks_that_a_recording_lacks_are_said(self):
        self.start("--rate", "10000", "--no-index-file", hand=(), env={**os.environ, "LD_PRELOAD": STUCK_DISK})
        call = self.client()
        self.assertTrue(call("/palpate/record", data=True)["success"])
        time.sleep(9.0)
        self.assertTrue(call("/palpate/record", data=False)["success"])
        self.assertRegex(self.parameters(call)["message"], r"the recording lacks \d+ ticks: the disk is too slow")

    def test_a_disk_that_is_full_ends_a_recording_and_nothing_else(self):
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))

        self.start(preexec_fn=limit)
        call = self.client()
        self.assertTrue(call("/palpate/record", data=True)["success"])
        self.until(lambda: self.parameters(call)["recorded"])
        now = self.parameters(call)
        self.assertFalse(now["recording"])
        self.assertIn("the recording was ended", now["message"])
        self.assertFalse(call("/palpate/record", data=False)["success"], "it has ended")
        status, _, body = self.ask("/recording")
        self.assertEqual(status, 200)
        lines = table_of(body).split("\n")
        self.assertGreater(len(lines), 100)
        self.assertEqual({line.count(",") for line in lines[:-1]}, {lines[0].count(",")}, "whole to the last row")
        self.assertEqual(lines[-1], "")
        self.assertEqual(self.ask("/healthz")[0], 200)
        self.assertTrue(call("/palpate/record", data=True)["success"], "another may begin")
        self.assertNotIn("the recording", self.parameters(call)["message"])
        self.assertNotIn("recorder", self.end()["faults"])

    def test_what_is_asked_for_at_once_is_done_in_turn(self):
        os.mkdir(self.path("scenes"))
        self.write("scenes/other.ply", ply(wall_rows(5)))
        self.start("--scenes", "scenes")
        call = self.client()
        send, receive = self.socket()
        other = next(scene["id"] for scene in json.loads(call("/palpate/list_scenes")["message"]) if scene["name"] == "other.ply")

        def ask(*requests):
            """What each of these, sent without waiting, was answered."""
            for k, (service, data) in enumerate(requests):
                send({"op": "call_service", "service": f"/palpate/{service}", "args": {"data": data}, "id": str(k)})
            answers = {}
            while len(answers) < len(requests):
                message = json.loads(receive()[1])
                answers[int(message["id"])] = message["values"]["success"]
            return [answers[k] for k in range(len(requests))]

        self.assertEqual(ask(("record", True), ("open_scene", other)), [True, False])
        self.assertTrue(self.parameters(call)["recording"])
        self.assertEqual(ask(("record", False)), [True])
        self.assertEqual(ask(("record", True), ("record", False)), [True, True])
        self.assertFalse(self.parameters(call)["recording"])
        self.assertEqual(ask(("record", False)), [False])
        self.assertEqual(self.parameters(call)["scene"]["name"], "wall.ply")
        self.end()

    @unittest.skipIf(SANITIZED or "PALPATE_LONG" not in os.environ, "takes five minutes, and a sanitized program does not keep up on one core")
    def test_five_minutes_with_clients_lose_no_row_and_take_no_more_memory(self):
        self.write("hand.csv", press_path(seconds=400))
        self.start("--record", "run.csv", "--hand", "0.1,30,1000")
        for k in range(8):
            send, receive = self.socket()
            for topic in EVERY_TOPIC:
                send({"op": "subscribe", "topic": f"/palpate/{topic}", "compression": ("none", "cbor")[k % 2]})
            if k:  # the first never reads
                threading.Thread(target=self.read_all, args=(receive,), daemon=True).start()
        call = self.client()
        resident = []  # KiB
        for _ in range(60):
            time.sleep(5)
            call("/palpate/set_parameters", json=json.dumps({"stiffness": 400 + len(resident)}))
            status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
            resident.append(int(re.search(r"VmRSS:\s+(\d+)", status)[1]))
        summary = self.end()
        lines = table_of(self.read("run.csv")).split("\n")
        self.assertTrue(lines[0].startswith("t,"))
        times = [float(line.split(",", 1)[0]) for line in lines[1:-1]]
        self.assertEqual(times, sorted(set(times)))
        self.assertGreater(summary["ticks"], 250_000)
        self.assertGreater(summary["contact_ticks"], 100_000)
        self.assertGreaterEqual(len(times), summary["ticks"])
        self.assertLess(max(resident) - resident[5], 4096, resident)

    def read_all(self, receive):
        try:
            while receive()[0] != 8:
                pass
        except (OSError, ValueError):
            pass  # the run has ended


class Stopped(Gateway):
    def test_a_pause_shows_beside_an_emergency_stop_and_ends_by_itself(self):
        self.start()
        call = self.client()

        def until(**expected):
            self.until(lambda: {key: self.parameters(call)[key] for key in expected} == expected)

        call("/palpate/pause", data=True)
        until(paused=True, clutch=False)
        call("/palpate/emergency_stop")
        call("/palpate/clutch", data=True)
        until(paused=True, clutch=True)
        call("/palpate/pause", data=False)
        call("/palpate/clutch", data=False)
        until(paused=False, clutch=False)
        call("/palpate/pause", data=True)
        until(paused=True)
        call("/palpate/resume")
        until(paused=False)
        self.end()


class Silent(Gateway):
    def test_hundreds_that_say_nothing_lock_nobody_out(self):
        for token in ((), ("--token", TOKEN)):
            with self.subTest(token=token):
                self.start(*token)
                send, receive = self.socket()
                send({"op": "subscribe", "topic": "/palpate/spatial/servo_cf"})
                silent = []
                for k in range(300):
                    silent.append(self.connect())
                    if k % 2:
                        silent[-1].sendall(b"GET / HTTP/1.1\r\nHost: x")
                begun = time.monotonic()
                send_late, receive_late = self.socket()
                send_late({"op": "subscribe", "topic": "/palpate/spatial/servo_cf"})
                for hears in (receive, receive_late):
                    for _ in range(30):
                        self.assertIn("wrench", json.loads(hears()[1])["msg"])
                self.assertLess(time.monotonic() - begun, 15)  # s; it was half a minute before anybody got in
                self.end()


class Hostile(Gateway):
    """The loop's own figures do not show it: the tool rests out of contact, active, and nothing faults."""

    def test_nothing_that_clients_do_reaches_the_loop(self):
        for _ in range(3):  # where the machine stands still it faults, and rightly; the third is judged whatever the machine did
            summary = self.endure()
            if stood_still(summary) < 10_000 and "late-tick" not in summary["faults"]:
                break
        self.assertEqual((summary["state"], summary["faults"], summary["contact_ticks"]), ("active", [], 0))

    def endure(self):
        self.start()
        for _ in range(40):  # half open, and silent
            self.connect().sendall(b"GET / HTTP/1.1\r\nHost: x")
        send, receive = self.socket()
        send(b"\xff\xfe")  # no text: RFC 6455 closes for that
        self.assertEqual(receive(), (8, struct.pack(">H", 1007)))
        send, receive = self.socket()
        pose = {"position": {"x": 0, "y": 0, "z": 0.05}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}
        hand = {"op": "publish", "topic": "/palpate/client/measured_cp", "msg": {"pose": pose}}
        bad = [b"", b"{", b"[" * 5000, b"null", b"{}", b'{"op":7}', {"op": "fly"}, {"op": "subscribe"},
               {"op": "subscribe", "topic": "/none"}, {"op": "advertise", "topic": "/palpate/tool", "type": "x/Y"},
               {**hand, "msg": 5}, {**hand, "msg": {}}, {**hand, "msg": {"pose": {**pose, "orientation": {"w": 0}}}},
               {**hand, "msg": {"pose": {**pose, "position": {"x": "NaN", "y": 0, "z": 0}}}},
               b'{"op":"publish","topic":"/palpate/client/measured_cp","msg":{"pose":{"position":{"x":1e999}}}}',
               {"op": "subscribe", "topic": "/palpate/tool", "compression": "png"},
               {"op": "subscribe", "topic": "/palpate/tool", "throttle_rate": "often"}]
        for message in bad:
            send(message)
            opcode, answer = receive()
            self.assertEqual(opcode, 1)
            answer = json.loads(answer)
            self.assertEqual((answer["op"], answer["level"]), ("status", "error"), message)
            self.assertTrue(answer["msg"])
        send(b"\x9f" * 100, opcode=2)
        self.assertIn("CBOR", json.loads(receive()[1])["msg"])
        send({"op": "call_service", "service": "/palpate/set_parameters", "args": {"json": '{"stiffness": -1}'}})
        self.assertFalse(json.loads(receive()[1])["values"]["success"])
        closed, messages, begun = False, 20000, time.monotonic()  # a flood
        try:
            for _ in range(messages):
                send({"op": "nothing"})
            while messages > 0 and not closed:
                opcode, _ = receive()
                messages, closed = messages - 1, opcode == 8
        except (OSError, ValueError):
            closed = True  # it was reset, having not read
        # 5000 a second are permitted, and as many at once: with a sanitizer it may take so long for them that they are no flood.
        self.assertTrue(closed or (SANITIZED and time.monotonic() - begun > 3.0))
        time.sleep(0.5)
        self.assertEqual(self.ask("/healthz")[0], 200)
        return self.end()


if __name__ == "__main__":
    unittest.main()
