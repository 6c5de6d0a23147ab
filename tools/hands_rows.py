"""Runs hands over one scene, in one process and in many, and prints what they take as rows of a table.
Usage: hands_rows.py PALPATE SCENE FOLDER"""

import json
import os
import statistics
import subprocess
import sys
import time

PATHS = 8  # of different seeds; hands take them in turn
SETTLE, MEASURE, REST = 6.0, 8.0, 2.0  # s: until all run, of which CPU is counted, until they end by themselves
COUNTS = [1, 8, 32]
TICKS = os.sysconf("SC_CLK_TCK")

palpate, scene, folder = sys.argv[1:]


def path_of(hand):
    return os.path.join(folder, f"path-{hand % PATHS}.csv")


def prepare():
    """Paths that touch the scene, and the index, so that no run has to make it."""
    for k in range(PATHS):
        subprocess.run([palpate, "make-path", scene, "--seed", str(k + 1), "--touches", "3", "--out", path_of(k), "-q"], check=True)
        with open(os.path.join(folder, f"hand-{k}.toml"), "w") as file:
            file.write(f'trajectory = "{path_of(k)}"\n')


def start(hands, seconds):
    """A process with so many hands; the numbers of their paths."""
    arguments = [palpate, "run", scene, "--trajectory", path_of(hands[0]), "--no-gateway", "--json", "-q", "--seconds", str(seconds)]
    others = [f"h{k}=" + os.path.join(folder, f"hand-{k % PATHS}.toml") for k in hands[1:]]
    return subprocess.Popen(arguments + (["--hands", ",".join(others)] if others else []), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE)


def cpu_of(process):
    with open(f"/proc/{process.pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def memory_of(process):
    """Resident, proportional, shared and private, in MB."""
    with open(f"/proc/{process.pid}/smaps_rollup") as file:
        kb = {line.split(":")[0]: int(line.split()[1]) for line in file if line.rstrip().endswith("kB")}
    shared, private = (sum(kb[f"{what}_{how}"] for how in ("Clean", "Dirty")) for what in ("Shared", "Private"))
    return [value / 1024 for value in (kb["Rss"], kb["Pss"], shared, private)]


def row(name, groups):
    count = sum(len(hands) for hands in groups)
    processes = [start(hands, SETTLE + MEASURE + REST) for hands in groups]
    time.sleep(SETTLE)
    before, begin = sum(map(cpu_of, processes)), time.monotonic()
    time.sleep(MEASURE)
    cores = (sum(map(cpu_of, processes)) - before) / (time.monotonic() - begin)
    resident, proportional, shared, private = (sum(each) for each in zip(*map(memory_of, processes)))
    documents = [json.loads(process.communicate()[0]) for process in processes]
    hands = documents + [hand for document in documents for hand in document.get("hands", {}).values()]
    assert len(hands) == count, (len(hands), count)
    ticks, overruns = (sum(hand[name] for hand in hands) for name in ("ticks", "overruns"))
    p50 = statistics.median(hand["tick_us"]["p50"] for hand in hands)
    p99 = statistics.median(hand["tick_us"]["p99"] for hand in hands)
    late = statistics.median(hand["late_us"]["p99"] for hand in hands)
    print(f"| {count} | {name} | {100 * cores:.0f} | {count / cores:.0f} | {resident:.0f} | {proportional:.0f} | {shared / len(groups):.0f} | "
          f"{private / len(groups):.1f} | {p50:.1f} | {p99:.1f} | {late:.0f} | {100 * overruns / (ticks + overruns):.2f} |", flush=True)


prepare()
print("| hands | processes | CPU % | hands per core | RSS MB | PSS MB | shared MB a process | private MB a process | tick p50 µs | p99 µs | "
      "late p99 µs | ticks left out % |")
print("|---|---|---|---|---|---|---|---|---|---|---|---|")
for count in COUNTS:
    row("one", [range(count)])
for count in COUNTS[1:]:
    row("one each", [[k] for k in range(count)])
