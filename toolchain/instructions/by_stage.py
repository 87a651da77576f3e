#!/usr/bin/env python3
"""Sums what count.c wrote by stage.

    by_stage.py PROGRAM LINK_MAP COUNTS [PROGRAM LINK_MAP COUNTS ...]

A stage is the library (libldp_NAME.a) that the linker took the code from, as its map says; code of other libraries goes by
their names. One column per program, in millions, and how the second relates to the first.
"""
import bisect
import os
import re
import subprocess
import sys


def sections(link_map):
    """(address, size, archive) of every piece of code in the program."""
    pieces, name = [], None
    for line in open(link_map, errors="replace"):
        found = re.match(r"^ (\.text\S*)?\s+0x([0-9a-f]+)\s+0x([0-9a-f]+) (\S.*)$", line)
        if line.startswith(" .text") and not found:
            name = line.strip()
        elif found and (found.group(1) or name):
            pieces.append((int(found.group(2), 16), int(found.group(3), 16), found.group(4)))
            name = None
        else:
            name = None
    return sorted(p for p in pieces if p[1] > 0 and p[0] > 0)


def stage_of(path):
    found = re.search(r"lib(ldp_)?([A-Za-z0-9_+-]+?)\.(a|so)", path)
    if found:
        return found.group(2) if found.group(1) else f"({found.group(2)})"
    return "program" if "device/" in path else "(run time)"


def text_offset(program):
    """Address of the first executable segment, and its offset in the file."""
    for line in subprocess.run(["readelf", "-lW", program], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines():
        fields = line.split()
        if fields and fields[0] == "LOAD" and "E" in fields[6:-1]:
            return int(fields[2], 16), int(fields[1], 16)
    raise SystemExit(f"{program}: no code")


def by_stage(program, link_map, counts):
    pieces = sections(link_map)
    starts = [p[0] for p in pieces]
    maps, blocks = [], []
    for line in open(counts):
        if line.startswith("map "):
            fields = line.split()
            if len(fields) > 6:
                low, high = (int(x, 16) for x in fields[1].split("-"))
                maps.append((low, high, int(fields[3], 16), fields[6]))
        else:
            count, address = (int(x, 16) for x in line.split())
            blocks.append((address, count))
    own = os.path.realpath(program)
    base = min(low - offset for low, _, offset, path in maps if os.path.realpath(path) == own)
    sums = {}
    for address, count in blocks:
        stage = "(run time)"
        for low, high, _, path in maps:
            if low <= address < high:
                stage = stage_of(os.path.basename(path))
                if os.path.realpath(path) == own:
                    i = bisect.bisect_right(starts, address - base) - 1
                    inside = i >= 0 and address - base < pieces[i][0] + pieces[i][1]
                    stage = stage_of(pieces[i][2]) if inside else "program"
                break
        sums[stage] = sums.get(stage, 0) + count
    return sums


def main():
    arguments = sys.argv[1:]
    if not arguments or len(arguments) % 3:
        raise SystemExit(__doc__)
    tables = [by_stage(*arguments[i:i + 3]) for i in range(0, len(arguments), 3)]
    stages = sorted(set().union(*tables), key=lambda s: -tables[0].get(s, 0))
    for stage in stages + ["all"]:
        row = [sum(t.values()) if stage == "all" else t.get(stage, 0) for t in tables]
        if max(row) < 0.001 * sum(tables[0].values()):
            continue
        ratio = f"{row[1] / row[0]:8.2f}" if len(row) > 1 and row[0] else ""
        print(f"{stage:<20}" + "".join(f"{x / 1e6:12.0f}" for x in row) + ratio)


if __name__ == "__main__":
    main()
