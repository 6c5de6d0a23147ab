"""A link between two machines: a relay for TCP that delays, jitters and stalls what goes through it, each way.

    relay.py ADDRESS PORT TO_ADDRESS TO_PORT DELAY_MS JITTER_MS LOSS_PERCENT

Says "ready" and its port once it listens; of PORT 0 it takes one that is free.

It stands in for a slow network where the kernel has no netem, as far as TCP shows one to a program: bytes come in order,
DELAY_MS late, and up to JITTER_MS more. A lost segment holds up all that follow until it has been sent again: here LOSS_PERCENT
of what is read at once waits a round trip and 3 ms longer, as long as fast retransmission takes at 1000 messages a second.
"""

import queue
import random
import socket
import sys
import threading
import time


def pass_on(source, sink, delay, jitter, loss):
    """What comes from `source` goes to `sink` later, in order."""
    waiting = queue.SimpleQueue()

    def send():
        while True:
            due, data = waiting.get()
            time.sleep(max(0.0, due - time.monotonic()))
            try:
                sink.sendall(data)
                if not data:
                    sink.shutdown(socket.SHUT_WR)
            except OSError:
                return
            if not data:
                return

    threading.Thread(target=send, daemon=True).start()
    chance = random.Random(1)
    last = 0.0
    while True:
        try:
            data = source.recv(1 << 16)
        except OSError:
            data = b""
        due = time.monotonic() + delay + jitter * chance.random()
        if chance.random() < loss:
            due += 2.0 * delay + 3e-3
        last = max(last, due)
        waiting.put((last, data))
        if not data:
            return


def main(address, port, to_address, to_port, delay_ms, jitter_ms, loss_percent):
    link = float(delay_ms) / 1e3, float(jitter_ms) / 1e3, float(loss_percent) / 1e2
    listener = socket.create_server((address, int(port)))
    print(f"ready {listener.getsockname()[1]}", flush=True)
    while True:
        near, _ = listener.accept()
        far = socket.create_connection((to_address, int(to_port)))
        for end in (near, far):
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for source, sink in ((near, far), (far, near)):
            threading.Thread(target=pass_on, args=(source, sink, *link), daemon=True).start()


if __name__ == "__main__":
    main(*sys.argv[1:])
