"""The table of costs in docs/how-to/microcontroller.md, and the firmware beside `vademecum run`.

check calls it: `scenario` makes a scenario of the places that the contacts have, `double` compares the firmware's
probes with those of the program in double precision, `compare` and `--write` compare or write the table.
"""

import re
import struct
import sys

BEGIN, END = "<!-- measured by examples/firmware/check -->", "<!-- end -->"
# Nanoseconds of a count of the clock, and of an instruction under -icount shift=4.
CLOCK, INSTRUCTION = {"an386": 40.0, "an505": 50.0}, 16.0
BOARDS = {"an386": "Cortex-M4F", "an505": "Cortex-M33"}
# Numbers may differ by these shares: with the same tools, because the names of folders decide in which order functions
# are put and taken into others, and where a compiler of another version made the firmware.
SAME_TOOLS, OTHER_TOOLS = 0.02, 0.1
# The stack, in its column, grows or shrinks by a frame of kilobytes with a single function that is taken into another.
STACK, STACK_SHARE = 6, 0.15


def scenario():
    lines = [[float(x) for x in line.split()] for line in sys.stdin]
    print("duration = 1.0")
    for place, (tick, x, y, z, fx, fy, fz) in enumerate(lines):
        if fx == fy == fz == 0.0:
            continue
        print(f"\n[[contact]]\npoint = [{x}, {y}, {z}]\nforce = [{fx}, {fy}, {fz}]\nstart = {tick / 1000}")
        if place + 1 < len(lines):
            print(f"end = {lines[place + 1][0] / 1000}")


def double(expected, probes):
    value = lambda bits: struct.unpack(">d", bytes.fromhex(bits))[0]
    rows = [line.split(",") for line in open(probes) if line.strip()]
    columns = rows[0]
    exact = {round(float(row[0]) * 1000): [float(x) for x in row[2:]] for row in rows[1:]}
    pairs = []
    for line in open(expected):
        words = line.split()
        pairs.append((int(words[3]), value(words[5]), exact[int(words[1])][int(words[3])]))
    assert len(pairs) == 40, len(pairs)
    for probe in (0, 1):
        mine = [(a, b) for k, a, b in pairs if k == probe]
        size = max(abs(b) for _, b in mine)
        # A thousand steps, each rounded to 6e-8 of the largest number of its mode.
        apart = max(abs(a - b) for a, b in mine) / size
        assert 0 < apart < 1000 * 6e-8 * 10, f"{columns}: probe {probe} is {apart:.1e} from that of vademecum run"


def measured(results):
    rows, at = [], {}
    for line in open(results):
        words = line.split()
        if words[:1] == ["run"]:
            at = dict(language=words[1], board=words[2], modes=int(words[3]))
            rows.append(at)
        elif len(words) >= 2 and words[1].isdigit():
            at[words[0]] = int(words[1])
    table = []
    for row in rows:
        assert row["late"] == 0, f"{row}: a tick came too late"
        instructions = CLOCK[row["board"]] / INSTRUCTION
        flash = row[".vectors"] + row[".text"] + row[".rodata"] + row[".data"]
        ram = row[".data"] + row[".bss"] + row["lent"]
        step, tick = round(row["counts"] / 1000 * instructions), round(row["worst"] * instructions)
        numbers = [row["modes"], flash, row[".vademecum"], ram, row["stack"], step, tick]
        table.append([row["language"], BOARDS[row["board"]]] + numbers)
    assert len(table) == 12, table
    return table


def lines(table):
    head = ["", "processor", "modes", "flash, bytes", "file, bytes", "RAM, bytes", "stack, bytes",
            "instructions per step", "of a tick with a new contact"]
    yield "| " + " | ".join(head).strip() + " |"
    yield "|" + "---|" * len(head)
    for row in table:
        yield "| " + " | ".join(str(cell) for cell in row) + " |"


def main():
    if sys.argv[1] == "scenario":
        return scenario()
    if sys.argv[1] == "double":
        return double(*sys.argv[2:])
    action, results, page, versions = sys.argv[1:]
    table = measured(results)
    made = ["Made with", ""] + [f"- {version}" for version in versions.split("; ")]
    fresh = made + [""] + list(lines(table))
    text = open(page).read()
    before, rest = text.split(BEGIN)
    kept, after = rest.split(END)
    if action == "--write":
        open(page, "w").write(before + BEGIN + "\n\n" + "\n".join(fresh) + "\n\n" + END + after)
        return
    print("\n".join(fresh))
    kept = [line for line in kept.splitlines() if line]
    tools = lambda all: [line for line in all if line.startswith("- ")]
    same_tools = tools(kept) == tools(fresh)
    numbers = lambda line: [cell.strip() for cell in line.strip("|").split("|")]
    old, new = [[numbers(line) for line in all if re.match(r"\| (Rust|C) ", line)] for all in (kept, fresh)]
    if len(old) != len(new):
        sys.exit(f"firmware: the page has {len(old)} rows, {len(new)} were measured; run examples/firmware/check --write")
    for was, now in zip(old, new):
        share = SAME_TOOLS if same_tools else OTHER_TOOLS
        shares = [max(share, STACK_SHARE) if column == STACK else share for column in range(len(was))]
        allowed = lambda a, b, share: a == b or (a.isdigit() and abs(int(a) - int(b)) <= share * int(b))
        if not all(map(allowed, was, now, shares)):
            sys.exit(f"firmware: the page says {was}, measured is {now}; run examples/firmware/check --write")


main()
