"""The gateway of palpate run over plain sockets: who is refused, and that nothing a client does reaches the loop."""

import base64
import json
import os
import re
import socket
import struct
import subprocess
import time

from support import PALPATE, SANITIZED, Case, path_csv, ply, stood_still, wall_rows

PATIENCE = 60 if SANITIZED else 20
KEY = base64.b64encode(b"0123456789abcdef").decode()


class Gateway(Case):
    def setUp(self):
        super().setUp()
        self.write("wall.ply", ply(wall_rows()))
        self.write("hand.csv", path_csv([(0.0, 0.0, 0.0, 0.05), (60.0, 0.0, 0.0, 0.05)]))

    def start(self, *more):
        """A run whose port and token are then self.port and self.token."""
        self.process = subprocess.Popen(
            [PALPATE, "run", "wall.ply", "--trajectory", "hand.csv", "--port", "0", "--json", *more], cwd=self.folder,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
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

    def socket(self):
        """A WebSocket, as a pair of functions: send a text, and receive one."""
        connection = self.connect()
        connection.sendall((f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
                            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {KEY}\r\n\r\n").encode())
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
            length = {126: lambda: struct.unpack(">H", stream.read(2))[0],
                      127: lambda: struct.unpack(">Q", stream.read(8))[0]}.get(length, lambda: length)()
            return opcode & 15, stream.read(length)

        return send, receive


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

    def test_without_the_token_when_it_listens_to_others(self):
        self.start("--listen", "127.0.0.1", "--token", "s3cret")
        self.assertEqual(self.token, "s3cret")
        for headers in ({}, {"Authorization": "Bearer s3cre"}, {"Authorization": "Basic s3cret"}, {"Cookie": "palpate=x"}):
            self.assertEqual(self.ask(**headers)[0], 401, headers)
            self.assertEqual(self.upgrade(**headers), 401, headers)
        self.assertEqual(self.ask("/?token=s3cret2")[0], 401)
        status, head, _ = self.ask("/?token=s3cret")
        self.assertEqual(status, 200)
        self.assertIn("set-cookie: palpate=s3cret", head)
        self.assertIn("httponly", head)
        self.assertEqual(self.ask("/scene", Cookie="a=b; palpate=s3cret")[0], 200)
        self.assertEqual(self.ask("/scene", Authorization="Bearer s3cret")[0], 200)
        self.end()

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
        self.end()


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


class Hostile(Gateway):
    """The loop's own figures do not show it: the tool rests out of contact, active, and nothing faults."""

    def test_nothing_that_clients_do_reaches_the_loop(self):
        for _ in range(3):  # where the machine stands still it faults, and rightly; the third is judged whatever the machine did
            summary = self.endure()
            if stood_still(summary) < 10_000:
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
        for _ in range(20000):  # a flood
            try:
                send({"op": "nothing"})
            except OSError:
                break
        closed = False
        try:
            while not closed:
                opcode, reason = receive()
                closed = opcode == 8
        except (OSError, ValueError):
            closed = True  # it was reset, having not read
        self.assertTrue(closed)
        time.sleep(0.5)
        self.assertEqual(self.ask("/healthz")[0], 200)
        return self.end()


if __name__ == "__main__":
    import unittest

    unittest.main()
