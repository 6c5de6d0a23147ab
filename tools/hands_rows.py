"""Runs several hands in one scene, in one process and in many, and prints their CPU, memory and latency as table rows.
Usage: hands_rows.py PALPATE SCENE FOLDER"""

import json
import os
import statistics
import subprocess
import sys
import time

PATHS = 8  # trajectories with different seeds; hands use them in turn
SETTLE, MEASURE = 4.0, 8.0  # s: wait after the start of all loops, and duration of the measurement
PATIENCE = 120.0  # s: longest wait for the loops to start
COUNTS = [1, 8, 32]
TICKS = os.sysconf("SC_CLK_TCK")

palpate, scene, folder = sys.argv[1:]


def path_of(hand):
    return os.path.join(folder, f"path-{hand % PATHS}.csv")


def prepare():
    """Makes the trajectories, and the index file, so that no run has to build it."""
    for k in range(PATHS):
        subprocess.run([palpate, "make-path", scene, "--seed", str(k + 1), "--touches", "3", "--out", path_of(k), "-q"], check=True)
        with open(os.path.join(folder, f"hand-{k}.toml"), "w") as file:
            file.write(f'trajectory = "{path_of(k)}"\n')


def start(hands):
    """Starts a process with these hands, which runs until it is terminated."""
    arguments = [palpate, "run", scene, "--trajectory", path_of(hands[0]), "--no-gateway", "--json", "-q"]
    others = [f"h{k}=" + os.path.join(folder, f"hand-{k % PATHS}.toml") for k in hands[1:]]
    return subprocess.Popen(arguments + (["--hands", ",".join(others)] if others else []), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE)


def loops_of(process):
    """Number of servo threads of a process."""
    names = (f"/proc/{process.pid}/task/{task}/comm" for task in os.listdir(f"/proc/{process.pid}/task"))
    return sum(open(name).read() == "palpate-servo\n" for name in names)


def cpu_of(process):
    with open(f"/proc/{process.pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def memory_of(process):
    """Resident, proportional, shared and private memory, in MB."""
    with open(f"/proc/{process.pid}/smaps_rollup") as file:
        kb = {line.split(":")[0]: int(line.split()[1]) for line in file if line.rstrip().endswith("kB")}
    shared, private = (sum(kb[f"{what}_{how}"] for how in ("Clean", "Dirty")) for what in ("Shared", "Private"))
    return [value / 1024 for value in (kb["Rss"], kb["Pss"], shared, private)]


def measure(name, groups, processes):
    """One row of the table, of processes that were started for these groups of hands; it ends them."""
    count = sum(len(hands) for hands in groups)
    until = time.monotonic() + PATIENCE
    while sum(map(loops_of, processes)) < count:
        assert time.monotonic() < until, "they do not start"
        time.sleep(0.1)
    time.sleep(SETTLE)
    before, begin = sum(map(cpu_of, processes)), time.monotonic()
    time.sleep(MEASURE)
    cores = (sum(map(cpu_of, processes)) - before) / (time.monotonic() - begin)
    resident, proportional, shared, private = (sum(each) for each in zip(*map(memory_of, processes)))
    for process in processes:
        process.terminate()
    documents = [json.loads(process.communicate()[0]) for process in processes]
    hands = documents + [hand for document in documents for hand in document.get("hands", {}).values()]
    assert len(hands) == count, (len(hands), count)
    ticks, overruns = (sum(hand[name] for hand in hands) for name in ("ticks", "overruns"))
    p50 = statistics.median(hand["tick_us"]["p50"] for hand in hands)
    p99 = statistics.median(hand["tick_us"]["p99"] for hand in hands)
    late = statistics.median(hand["late_us"]["p99"] for hand in hands)
    return (f"| {count} | {name} | {100 * cores:.0f} | {count / cores:.0f} | {resident:.0f} | {proportional:.0f} | {shared / len(groups):.0f} | "
            f"{private / len(groups):.1f} | {p50:.1f} | {p99:.1f} | {late:.0f} | {100 * overruns / (ticks + overruns):.2f} |")


def row(name, groups):
    processes = [start(hands) for hands in groups]
    try:
        print(measure(name, groups, processes), flush=True)
    finally:
        for process in processes:
            process.kill()  # those that are left after an error


prepare()
print("| hands | processes | CPU % | hands per core | RSS MB | PSS MB | shared MB a process | private MB a process | tick p50 µs | p99 µs | "
      "late p99 µs | ticks left out % |")
print("|---|---|---|---|---|---|---|---|---|---|---|---|")
for count in COUNTS:
    row("one", [range(count)])
for count in COUNTS[1:]:
    row("one each", [[k] for k in range(count)])
