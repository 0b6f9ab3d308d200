#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders camera pictures of fiducials on printed circuit boards, with their truth.

Independent of panelcal's own renderer: written from optics and from looks of real boards. numpy only.
"""
import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")  # pictures go to several processes instead

import argparse
import json
import multiprocessing
import sys
import time
import zlib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import numpy as np

from simulator import cells, files, parameters
from simulator.picture import render

EPILOG = """
examples
  render.py cells                                   the cells, one line each
  render.py parameters                              the parameters, one line each
  render.py one --effect hasl --seed 7 -o hasl.png  one picture; its truth is the line that is printed
  render.py one --effect burr05:hole --seed 1 --set bore.burr_px=0.8 -o burr.png
  render.py set --cell typical,grain:hole -n 100 --seed 1 -o out --jobs 2
  render.py sheet -o sheet.png                      every cell once, side by side, to look at

A name is a cell, or cell:shape, shape one of disc hole ring square diamond cross tag triangle.
Frame: (0, 0) is the centre of the top-left pixel, x right, y down. The same command line renders the
same pictures, whatever --jobs is.
"""


def picture_seed(seed, name, index):
    """Seed of one picture of a set."""
    state = np.random.SeedSequence([seed, zlib.crc32(name.encode()), index]).generate_state(1)
    return int(state[0])


def tool(number, truth):
    """A [[vision.tool]] of a machine.toml that looks for this picture's target."""
    lines = ["[[vision.tool]]", f"number = {number}", f'shape = "{"apriltag" if truth["shape"] == "tag" else truth["shape"]}"',
             f'size_px = {truth["size_px"]}', f'polarity = "{truth["polarity"]}"']
    if "width_px" in truth:
        lines.append(f'width_px = {truth["width_px"]}')
    if "inner_px" in truth and truth["has_target"]:
        lines.append(f'inner_px = {truth["inner_px"]}')
    return "\n".join(lines) + "\n"


def _one_of_set(job):
    name, index, seed, folder, overrides = job
    mine = picture_seed(seed, name, index)
    p = cells.draw(name, mine, overrides)
    began = time.process_time()
    picture, truth = render(p, mine)
    spent = time.process_time() - began
    place = f"{name.replace(':', '-')}/{index:05d}.png"
    files.write(Path(folder) / place, picture)
    line = {"file": place, "cell": name, "tool": index + 1, **truth, "at_px": cells.search_place(p, mine)}
    return line, spent


def run_set(args):
    names = [n for n in args.cell.split(",") if n]
    if "all_cells" in names:
        names = [n for n in names if n != "all_cells"] + list(cells.CELLS)
    for name in names:
        cells.split(name)
        (Path(args.out) / name.replace(":", "-")).mkdir(parents=True, exist_ok=True)
    jobs = [(name, i, args.seed, args.out, args.set) for name in names for i in range(args.n)]
    spent, tools = {}, {}
    with open(Path(args.out) / "truth.jsonl", "w", encoding="ascii") as f:
        if args.jobs > 1:
            pool = multiprocessing.get_context("fork").Pool(args.jobs)
            results = pool.imap(_one_of_set, jobs, chunksize=4)
        else:
            results = map(_one_of_set, jobs)
        for line, seconds in results:
            f.write(json.dumps(line) + "\n")
            spent.setdefault(line["cell"], []).append(seconds)
            tools.setdefault(line["cell"], []).append(tool(line["tool"], line))
    for name, parts in tools.items():
        (Path(args.out) / name.replace(":", "-") / "machine.toml").write_text("\n".join(parts), encoding="ascii")
    for name in names:
        print(f"{name}: {args.n} pictures, {1000 * np.median(spent[name]):.0f} ms each (median, processor time)", file=sys.stderr)


def run_one(args):
    if args.params:
        p = parameters.merged(json.loads(Path(args.params).read_text(encoding="utf-8")))
        for key, value in args.set:
            parameters.put(p, key, value)
    else:
        p = cells.draw(args.effect, args.seed, args.set)
    picture, truth = render(p, args.seed)
    files.write(args.out, picture)
    print(json.dumps({"file": str(args.out), "cell": args.effect if not args.params else None, **truth,
                      "at_px": cells.search_place(p, args.seed)}))


def run_sheet(args):
    """Tiles of 8 bits, each scaled to its own bright end, in the order of `cells`."""
    names = args.cell.split(",") if args.cell else list(cells.CELLS)
    tiles = []
    for name in names:
        mine = picture_seed(args.seed, name, 0)
        picture, _ = render(cells.draw(name, mine, args.set), mine)
        a = picture.astype(np.float32)
        a = a / max(float(a.max()) if picture.dtype == np.uint16 else 255.0, 1)
        if a.ndim == 2:
            a = np.repeat(a[..., None], 3, 2)
        tiles.append(np.pad((a * 255).astype(np.uint8), ((2, 2), (2, 2), (0, 0)), constant_values=255))
    columns = args.columns
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % columns)
    files.write(args.out, np.concatenate([np.concatenate(tiles[i:i + columns], 1) for i in range(0, len(tiles), columns)], 0))
    for i in range(0, len(names), columns):
        print(f"row {i // columns + 1}: " + " ".join(names[i:i + columns]))


def list_cells(args):
    for name, (text, *_) in cells.CELLS.items():
        print(f"{name:18s} {text}")


def list_parameters(args):
    for name, value, unit, text, span, source in parameters.TABLE:
        print(f"{name:28s} {json.dumps(value):22s} {unit:6s} {text}" + (f"; realistic: {span}" if span else "") + (f" ({source})" if source else ""))


def assignment(text):
    name, equals, value = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError(f'no "=": "{text}"; write group.name=value')
    try:
        return name, json.loads(value)
    except json.JSONDecodeError:
        return name, value


def main():
    parser = argparse.ArgumentParser(prog="render.py", description=__doc__, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True, metavar="one | set | sheet | cells | parameters")
    change = {"action": "append", "default": [], "type": assignment, "metavar": "NAME=VALUE",
              "help": "change a parameter after the cell has drawn; value as JSON or text; may be repeated"}

    one = commands.add_parser("one", help="render one picture and print its truth as a line of JSON")
    source = one.add_mutually_exclusive_group(required=True)
    source.add_argument("--effect", metavar="CELL[:SHAPE]", help="draw the parameters from a cell")
    source.add_argument("--params", metavar="FILE.json", help="take them from a file: nested or flat; the rest are defaults")
    one.add_argument("--seed", type=int, default=1, help="of everything random (default 1)")
    one.add_argument("-o", "--out", required=True, metavar="PICTURE", help="a .png, or a .jpg of 8 bits")
    one.add_argument("--set", **change)
    one.set_defaults(run=run_one)

    many = commands.add_parser("set", help="render n pictures of each cell, truth.jsonl and a machine.toml per cell")
    many.add_argument("--cell", required=True, metavar="CELL[:SHAPE],...", help='names, or "all_cells"')
    many.add_argument("-n", "--n", type=int, default=10, help="pictures a cell (default 10)")
    many.add_argument("--seed", type=int, default=1, help="of the whole set (default 1)")
    many.add_argument("-o", "--out", required=True, metavar="FOLDER")
    many.add_argument("--jobs", type=int, default=1, help="processes (default 1); pictures do not depend on it")
    many.add_argument("--set", **change)
    many.set_defaults(run=run_set)

    sheet = commands.add_parser("sheet", help="one picture with every cell, to look at")
    sheet.add_argument("--cell", metavar="CELL[:SHAPE],...", help="these cells instead of all")
    sheet.add_argument("--seed", type=int, default=1)
    sheet.add_argument("--columns", type=int, default=10)
    sheet.add_argument("-o", "--out", required=True, metavar="PICTURE")
    sheet.add_argument("--set", **change)
    sheet.set_defaults(run=run_sheet)

    commands.add_parser("cells", help="list the cells").set_defaults(run=list_cells)
    commands.add_parser("parameters", help="list the parameters: default, unit, meaning, range, source").set_defaults(run=list_parameters)
    args = parser.parse_args()
    args.run(args)


if __name__ == "__main__":
    main()
