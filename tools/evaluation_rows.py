#!/usr/bin/env python3
"""Prints table rows from the JSON of palpate reproduce: the project's default force model, the worst of all places.

usage: evaluation_rows.py MECHANICS HAND RUN.json
"""
import json
import sys


def row(mechanics, hand, run):
    contacts = run["contacts"]
    off = max(abs(c["user_force"] - c["force"]) / c["force"] for c in contacts)
    cells = [
        mechanics if run["device"] == "admittance" else "none",
        hand,
        run["device"],
        f"{max(c['swing_mm'] for c in contacts):.3f}",
        f"{max(c['overshoot_mm'] for c in contacts):.2f}",
        f"{100 * off:.1f} %",
        f"{min(c['force'] for c in contacts):.2f} to {max(c['force'] for c in contacts):.2f}",
        f"{run['port_energy_mj']:.3f}" + ("" if not run["faults"] else f" ({', '.join(run['faults'])})"),
    ]
    return "| " + " | ".join(cells) + " |"


def main():
    mechanics, hand, path = sys.argv[1:]
    with open(path) as file:
        runs = json.load(file)["runs"]
    for run in runs:
        # The impedance device has no mechanics to choose: one row is enough.
        if run["model"] != "density" and (run["device"] == "admittance" or mechanics == "own"):
            print(row(mechanics, hand, run))


main()
