#!/usr/bin/env python3
"""Measures the core (adjacency, levels, tree, selection, labels, borders, cleaning, memory, cache) and prints the tables
of docs/performance.md.

  core_figures.py FOLDER_OF_PROGRAMS [--write docs/performance.md] [--repetitions 3] [--cpu] [--large]

--write puts them between the marks of that file. --cpu takes processor time in place of the clock on the wall: for one
thread only, where other programs run at the same time. --large adds 4 and 40 million triangles.
"""
import argparse
import json
import pathlib
import re
import subprocess

FIELDS = ["smooth/ordered", "rough/ordered", "smooth/shuffled", "rough/shuffled"]
MARKS = ("<!-- core: begin -->", "<!-- core: end -->")


def measure(folder, pattern, repetitions, cpu, environment=None):
    """ns a triangle by name of the benchmark: the least of the repetitions in two rounds, which other programs disturbed
    least."""
    command = [folder / "tree_bench", f"--benchmark_filter={pattern}", f"--benchmark_repetitions={repetitions}",
               "--benchmark_min_time=0.1", "--benchmark_format=json"]
    runs = []
    for _ in range(2):
        text = subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              env=environment).stdout
        runs += json.loads(text)["benchmarks"]
    found = {}
    for run in runs:
        if run["run_type"] != "iteration":
            continue
        name = run["run_name"].removesuffix("/real_time")
        size = re.search(r"/(\d+)([kM])/", name)
        triangles = int(size[1]) * (1000 if size[2] == "k" else 1000000) if size else 1000000
        time = run["cpu_time" if cpu else "real_time"] * 1e6 / triangles
        found[name] = min(time, found.get(name, time))
    return found


def core_table(times, size, cpu):
    def cell(what, field, digits=0):
        value = times.get(f"{what}/{size}/field/{field}")
        return "" if value is None else f"{value:.{digits}f}"

    rows = [("adjacency", "adjacency", 0), ("levels and areas", "quantise_and_areas", 0), ("tree with areas", "tree", 0),
            ("tree of every distinct value, with its sort", "tree_every_value", 0),
            ("selection and labels", "select_and_label", 1), ("borders of all regions", "borders", 0),
            ("whole", "whole", 0), ("contrasts of the regions", "contrasts", 0),
            ("cleaning: filters, contrasts, watershed, absorb", "cleaning", 0),
            ("attributes and fitted shapes of all regions", "attributes", 0), ("tree of shapes", "tree_of_shapes", 0)]
    lines = [f"| {size} triangles | " + " | ".join(f.replace("/", ", ") for f in FIELDS) + " |",
             "|---|" + "---|" * len(FIELDS)]
    for title, what, digits in rows:
        cells = []
        for field in FIELDS:
            one, two = cell(f"{what}/1", field, digits), cell(f"{what}/2", field, digits)
            cells.append(one + (f" ({two})" if two and not cpu else ""))
        if any(cells):
            lines.append(f"| {title} | " + " | ".join(cells) + " |")
    plain = [("std::map adjacency", "adjacency_plain"), ("std::map adjacency, met edges erased", "adjacency_plain_erasing"),
             ("sort and union-find", "tree_plain"), ("the same, joined by rank", "tree_plain_by_rank"),
             ("sort and union-find by value", "tree_every_value_plain")]
    for title, what in plain:
        lines.append(f"| *reference*: {title} | " + " | ".join(cell(what, field) for field in FIELDS) + " |")

    def ratio(title, above, below):
        cells = []
        for field in FIELDS:
            a, b = times.get(f"{above}/{size}/field/{field}"), times.get(f"{below}/{size}/field/{field}")
            cells.append(f"{a / b:.1f}x" if a and b else "")
        lines.append(f"| **{title}** | " + " | ".join(cells) + " |")

    ratio("adjacency against std::map", "adjacency_plain", "adjacency/1")
    ratio("adjacency against std::map, met edges erased", "adjacency_plain_erasing", "adjacency/1")
    ratio("tree against sort and union-find", "tree_plain", "tree/1")
    ratio("tree against the same, joined by rank", "tree_plain_by_rank", "tree/1")
    ratio("tree of every value against sort and union-find by value", "tree_every_value_plain", "tree_every_value/1")
    if not cpu:
        ratio("whole, two threads against one", "whole/1", "whole/2")
    return lines


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--write", type=pathlib.Path)
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--cpu", action="store_true")
    parser.add_argument("--large", action="store_true")
    options = parser.parse_args()
    lines = []
    times = measure(options.folder, "/1M/field", options.repetitions, options.cpu)
    lines += core_table(times, "1M", options.cpu) + [""]
    if options.large:
        # Without attributes and shapes, which would take as long as all others.
        core = "adjacency|quantise|tree/|tree_plain|tree_every_value|select|borders|whole|contrasts|cleaning"
        large = measure(options.folder, f"^({core}).*/4M/field", 1, options.cpu)
        lines += core_table(large, "4M", options.cpu) + [""]

    nested = measure(options.folder, "borders_nested", options.repetitions, options.cpu)
    depth = {int(name.rsplit("_", 1)[1]): value for name, value in nested.items()}
    lines.append("Borders at equal output, ns a triangle by depth of nesting: " +
                 ", ".join(f"{d} deep {depth[d]:.1f}" for d in sorted(depth)) + ".")
    lines.append("")
    sizes = ["1000000", "40000000"] if options.large else ["1000000"]
    programs = [["memory_bench", size] for size in sizes] + [["stages_bench", "1000000", "1", "5"]]
    if not options.cpu:
        programs.append(["stages_bench", "1000000", "2", "5"])
    for program in programs:
        text = subprocess.run([options.folder / program[0], *program[1:]], check=True, stdout=subprocess.PIPE,
                              text=True).stdout
        lines += ["`" + " ".join(program) + "`", "", "```", text.rstrip(), "```", ""]
    text = "\n".join(lines).rstrip() + "\n"
    if options.write is None:
        print(text, end="")
        return
    page = options.write.read_text()
    before, rest = page.split(MARKS[0])
    after = rest.split(MARKS[1])[1]
    options.write.write_text(f"{before}{MARKS[0]}\n{text}{MARKS[1]}{after}")


if __name__ == "__main__":
    main()
