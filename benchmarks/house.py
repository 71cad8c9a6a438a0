"""Figures of the code as a house: rooms, lengths, density, docstrings, names, imports.

``python -m benchmarks.house [CHECKOUT ...]`` prints a table with one column a checkout (default: this one).
A CHECKOUT is a folder, or a commit of this repository, which is checked out for the time of the count.
``--json FILE`` stores the figures and writes the page of the same name beside it; ``--page FILE`` only writes the page.
Only the standard library is used, and nothing of the checkout is imported, so that older trees are measured, too.
"""

from __future__ import annotations

import argparse
import ast
import datetime
import io
import json
import re
import statistics
import subprocess
import sys
import tempfile
import tokenize
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
NOT_SHIPPED = {"haptid", "tests", "benchmarks", "docs"}  # haptid/ holds links to the packages
ENTRY = "discrepancy.run"
WORK = "discrepancy.search_campaign"
"""Module that the command loads by its name when it runs, in trees that have it: no import leads from `ENTRY` there."""

Function = ast.FunctionDef | ast.AsyncFunctionDef
COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
SECTION = re.compile(
    r"^\s*(Parameters|Returns|Raises|Yields|Attributes|Notes|References|Examples|See Also)\n\s*-{3,}\s*$", re.M
)
IRREGULAR = re.compile(
    "begun|bent|born|bought|bound|built|caught|come|cut|done|drawn|driven|fed|felt|found|frozen|given|gone|grown|held|"
    "hidden|kept|known|laid|left|lost|made|meant|met|paid|put|read|run|said|seen|sent|shown|split|spent|stood|stuck|"
    "swept|taken|taught|thrown|told|torn|understood|worn|woven|written"
)
NO_PARTICIPLE = re.compile("embed|exceed|feed|need|proceed|red|seed|shed|speed|succeed")

MEANINGS = {
    "files": "modules",
    "largest_folder": "modules in the largest folder",
    "lines": "lines",
    "shipped_lines": "lines without `studies/`, which no wheel has",
    "code_lines": "lines of code",
    "file_lines_median": "lines of a module, median",
    "file_lines_p90": "lines of a module, 90th percentile",
    "body_statements_median": "statements of a function body, median",
    "body_statements_p90": "statements of a function body, 90th percentile",
    "statements_per_line": "statements per line of code",
    "nodes_per_line": "syntax nodes per line of code",
    "comprehensions_per_1000_lines": "comprehensions per 1,000 lines",
    "comment_share": "lines with a comment, share",
    "docstrings_with_sections": "public docstrings with sections, share",
    "functions": "functions and methods",
    "bare_participles": "functions named by a bare participle",
    "numeric_constants": "numeric module constants outside `Thresholds`",
    "one_importer": "modules with exactly one importer",
    "longest_chain": "longest import chain, modules",
    "cycles": "import cycles",
    "reached_from_discrepancy": f"modules reached from `{ENTRY}`",
}


COUNTING = """
## How it is counted

- A module is a file other than `__init__.py`. Lines are all lines of all files.
- Statements are counted with those inside them. A docstring is not part of a body.
- A line of code is not blank, no comment and no docstring. Comments to the linters do not count as comments.
- A docstring has sections where it has an underlined heading (Parameters, Returns, Raises, Notes …).
- A bare participle is a name of one word that ends in -ed, or one of a list in the script (made, found, told …).
  Properties are left out.
- A numeric constant is a name that a module binds to a number, to arithmetic of numbers, or to a tuple of these.
- Imports count wherever they stand, for type checking too. Effects are found by their folder: no import leads to them.
- Modules that import each other in a circle are one cycle, and count as one module of a chain.
"""


MISSED = {
    "shipped_lines": (
        "They were to fall by merging. What was merged went, but sections of docstrings, the Python API, further laws "
        "of friction, the torque as residual, controllers, formats of tables and remarks came; `studies/` left the "
        "product."
    ),
    "reached_from_discrepancy": (
        "They were to fall. The command of the search calls the Python API and so reaches all that this puts together, "
        "reports, FMUs and both searches; the search in the position alone reaches about half of it."
    ),
    "longest_chain": (
        "One order of rooms, in which each imports those below it, makes a long chain of small steps; it has no cycle."
    ),
    "one_importer": (
        "Files of a few lines with one importer were to return to it. Rooms hold modules of one purpose each: a file "
        "of its own stays where it can be read and tested alone."
    ),
    "numeric_constants": (
        "All were to stand in `Thresholds`. Those that decide in the packages that compute do; what is left are "
        "formats, sizes of drawings, lengths of lists, tolerances of arithmetic, and the studies' own plans."
    ),
    "statements_per_line": (
        "It was to fall. Statements were not joined to keep a limit of lines, and none was split to lower this figure."
    ),
    "comment_share": (
        "Well-kept libraries have a few per cent. Reasons stand in docstrings of thresholds and in decisions; a "
        "comment stays where a line surprises."
    ),
}
"""Figure that missed its aim: why."""
OTHER_COUNTS = """
The aims were set on a count of the first of these trees: lines and functions are the same there. The other figures of
that count differ from those of the first column, as its rules do, which were not written down: here, modules reached
from the search leave out `__init__` files, comments to linters are no comments, participles may be irregular by a list
in the script, and a numeric constant is one that a module binds outside all classes.

Stored JSON beside these pages is not compressed: its changes are read in the history, and the ledger of studies grows
study by study.
"""


@dataclass(frozen=True, slots=True)
class Module:
    """One file of a package."""

    name: str  # without "haptid." in front
    folder: str
    text: str
    tree: ast.Module


def read_modules(checkout: Path) -> list[Module]:
    """Return all modules of the packages of a checkout; ``__init__`` files count only as what they import."""
    packages = sorted(p.parent for p in checkout.glob("*/__init__.py") if p.parent.name not in NOT_SHIPPED)
    modules = []
    for path in (p for package in packages for p in sorted(package.rglob("*.py"))):
        parts = path.relative_to(checkout).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        text = path.read_text(encoding="utf-8")
        modules.append(Module(name, path.parent.relative_to(checkout).as_posix(), text, ast.parse(text)))
    return modules


def is_init(module: Module) -> bool:
    """Return whether the module is a package's ``__init__``."""
    return module.name == module.folder.replace("/", ".")


def functions_of(module: Module) -> list[Function]:
    """Return all functions and methods, nested ones too."""
    return [node for node in ast.walk(module.tree) if isinstance(node, Function)]


def body_without_docstring(node: Function | ast.ClassDef | ast.Module) -> list[ast.stmt]:
    """Return the statements below the docstring."""
    return node.body[1:] if ast.get_docstring(node, clean=False) is not None else node.body


def count_statements(body: Iterable[ast.stmt]) -> int:
    """Return the number of statements, those inside others too."""
    return sum(isinstance(node, ast.stmt) for statement in body for node in ast.walk(statement))


def lines_of_code(module: Module) -> int:
    """Return the number of lines that are neither blank, nor comment, nor docstring."""
    tokens = tokenize.generate_tokens(io.StringIO(module.text).readline)
    silent = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
    lines: set[int] = set()
    for token in tokens:
        if token.type not in silent:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(module.tree):
        if isinstance(node, Function | ast.ClassDef | ast.Module) and ast.get_docstring(node) is not None:
            lines.difference_update(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    return len(lines)


def comment_lines(module: Module) -> int:
    """Return the number of lines that bear a comment; directives to the linters are none."""
    tokens = tokenize.generate_tokens(io.StringIO(module.text).readline)
    comments = (t.string for t in tokens if t.type == tokenize.COMMENT)
    return sum(not re.match(r"#\s*(noqa|type:|fmt:|!)", comment) for comment in comments)


def public_docstrings(node: ast.AST) -> Iterator[str]:
    """Yield the docstrings of public functions, classes and the public methods of these."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, Function | ast.ClassDef) and not child.name.startswith("_"):
            docstring = ast.get_docstring(child)
            if docstring is not None:
                yield docstring
            if isinstance(child, ast.ClassDef):
                yield from public_docstrings(child)


def is_bare_participle(function: Function) -> bool:
    """Return whether the name is one word that ends in -ed or is an irregular participle; properties may be."""
    if any("property" in ast.unparse(decorator) for decorator in function.decorator_list):
        return False
    word = function.name.strip("_")
    regular = word.isalpha() and word.endswith("ed") and not NO_PARTICIPLE.fullmatch(word)
    return regular or IRREGULAR.fullmatch(word) is not None


def is_number(node: ast.expr | None) -> bool:
    """Return whether an expression is a number, arithmetic of numbers, or a tuple of these."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.UnaryOp):
        return is_number(node.operand)
    if isinstance(node, ast.Tuple):
        return bool(node.elts) and all(map(is_number, node.elts))
    return isinstance(node, ast.BinOp) and is_number(node.left) and is_number(node.right)


def numeric_constants(module: Module) -> int:
    """Return the number of names that the module binds to numbers at its top level."""
    assigned = [s.value for s in module.tree.body if isinstance(s, ast.Assign | ast.AnnAssign)]
    return sum(is_number(value) for value in assigned)


def imports_of(module: Module, known: set[str]) -> set[str]:
    """Return the modules that one imports anywhere in its text, for type checking too."""
    found: set[str] = set()
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Import):
            names: list[tuple[str, str | None]] = [(alias.name, None) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = module.name.split(".")[: -node.level] if node.level else []
            origin = ".".join([*base, *([node.module] if node.module else [])])
            names = [(origin, alias.name) for alias in node.names]
        else:
            continue
        for origin, name in names:
            bare = origin.removeprefix("haptid.")
            inner = f"{bare}.{name}"
            found.update({inner if inner in known else bare} & known)
    return found - {module.name}


def cycles_of(graph: dict[str, set[str]]) -> list[set[str]]:
    """Return the sets of modules that import each other in a circle."""
    reach = {name: reached_from(graph, name) for name in graph}
    circles = {frozenset(other for other in reach[name] if name in reach[other]) for name in graph}
    return [set(circle) for circle in circles if len(circle) > 1]


def longest_chain(graph: dict[str, set[str]]) -> int:
    """Return the number of modules on the longest import chain; modules of one cycle count as one."""
    name_of = {name: name for name in graph}
    for circle in cycles_of(graph):
        name_of |= dict.fromkeys(circle, min(circle))

    below: dict[str, set[str]] = {}
    for name, imported in graph.items():
        below.setdefault(name_of[name], set()).update(name_of[other] for other in imported)

    @cache
    def length(name: str) -> int:
        return 1 + max((length(other) for other in below[name] - {name}), default=0)

    return max(map(length, below))


def reached_from(graph: dict[str, set[str]], entry: str) -> set[str]:
    """Return the modules that an entry point imports, directly or through others, itself included."""
    reached, waiting = set(), [entry]
    while waiting:
        name = waiting.pop()
        if name in graph and name not in reached:
            reached.add(name)
            waiting.extend(graph[name])
    return reached


def percentile_90(values: list[int]) -> int:
    """Return the 90th percentile."""
    return int(statistics.quantiles(values, n=10, method="inclusive")[-1])


def import_figures(modules: list[Module]) -> dict[str, int]:
    """Return the figures of the import graph, without ``__init__`` files."""
    known = {m.name for m in modules}
    inits = {m.name for m in modules if is_init(m)}
    graph = {m.name: imports_of(m, known) - inits for m in modules if not is_init(m)}
    importers = Counter(name for imported in graph.values() for name in imported)
    return {
        "one_importer": sum(count == 1 for count in importers.values()),
        "longest_chain": longest_chain(graph),
        "cycles": len(cycles_of(graph)),
        "reached_from_discrepancy": len(reached_from(graph, WORK if WORK in graph else ENTRY)),
    }


def figures_of(modules: list[Module]) -> dict[str, float]:
    """Return all figures of a tree."""
    files = [m for m in modules if not is_init(m)]
    functions = [f for m in modules for f in functions_of(m)]
    bodies = [count_statements(body_without_docstring(f)) for f in functions]
    lengths = [len(m.text.splitlines()) for m in files]
    lines = sum(len(m.text.splitlines()) for m in modules)
    code = sum(map(lines_of_code, modules))
    nodes = [node for m in modules for node in ast.walk(m.tree)]
    docstrings = [text for m in modules for text in public_docstrings(m.tree)]
    statements = sum(isinstance(node, ast.stmt) for node in nodes)
    figures = {
        "files": len(files),
        "largest_folder": max(Counter(m.folder for m in files).values()),
        "lines": lines,
        "shipped_lines": sum(len(m.text.splitlines()) for m in modules if m.name.partition(".")[0] != "studies"),
        "code_lines": code,
        "file_lines_median": int(statistics.median(lengths)),
        "file_lines_p90": percentile_90(lengths),
        "body_statements_median": int(statistics.median(bodies)),
        "body_statements_p90": percentile_90(bodies),
        "statements_per_line": round(statements / code, 3),
        "nodes_per_line": round(len(nodes) / code, 1),
        "comprehensions_per_1000_lines": round(1000 * sum(isinstance(n, COMPREHENSIONS) for n in nodes) / lines, 1),
        "comment_share": round(sum(map(comment_lines, modules)) / lines, 4),
        "docstrings_with_sections": round(sum(bool(SECTION.search(t)) for t in docstrings) / len(docstrings), 3),
        "functions": len(functions),
        "bare_participles": sum(map(is_bare_participle, functions)),
        "numeric_constants": sum(map(numeric_constants, modules)),
    }
    return figures | import_figures(modules)


def packages_of(modules: list[Module]) -> dict[str, dict[str, int]]:
    """Return modules, largest folder and lines of each package."""
    names = sorted({m.name.partition(".")[0] for m in modules})
    table = {}
    for name in names:
        inside = [m for m in modules if m.name.partition(".")[0] == name]
        folders = Counter(m.folder for m in inside if not is_init(m))
        table[name] = {
            "files": sum(folders.values()),
            "largest_folder": max(folders.values()),
            "lines": sum(len(m.text.splitlines()) for m in inside),
        }
    return table


@contextmanager
def checkout_of(name: str) -> Iterator[Path]:
    """Give the folder of this name; of a commit a checkout of its own, which goes again."""
    if Path(name).is_dir():
        yield Path(name)
        return
    git = ["git", "-C", str(ROOT), "worktree"]
    with tempfile.TemporaryDirectory() as parent:
        folder = Path(parent) / "checkout"
        done = subprocess.run([*git, "add", "--detach", str(folder), name], capture_output=True, text=True, check=False)
        if done.returncode:
            sys.exit(f"house: expected a folder or a commit, got {name!r}: {done.stderr.strip().splitlines()[-1]}")
        try:
            yield folder
        finally:
            subprocess.run([*git, "remove", "--force", str(folder)], capture_output=True, check=False)


def version_of(checkout: Path) -> str:
    """Return the commit of a checkout, with a plus where a module differs from it."""
    git = ["git", "-C", str(checkout)]
    commit = subprocess.run([*git, "rev-parse", "--short=7", "HEAD"], capture_output=True, text=True, check=True)
    status = subprocess.run([*git, "status", "--porcelain"], capture_output=True, text=True, check=True)
    changed = [line[3:] for line in status.stdout.splitlines() if line.endswith(".py")]
    mark = "+" if any(name.partition("/")[0] not in NOT_SHIPPED for name in changed) else ""
    return commit.stdout.strip() + mark


def measure(checkout: Path) -> dict[str, Any]:
    """Return what is stored of one checkout."""
    modules = read_modules(checkout)
    return {"version": version_of(checkout), "figures": figures_of(modules), "packages": packages_of(modules)}


def printed(value: float | None) -> str:
    """Return a number as the tables show it."""
    if value is None:
        return "–"
    return f"{value:,}" if isinstance(value, int) else f"{value:g}"


def markdown_table(header: list[str], rows: Iterable[list[str]]) -> str:
    """Return a Markdown table whose first column is text and whose others are numbers."""
    lines = [header, ["---"] + ["---:"] * (len(header) - 1), *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def missed_aims(trees: list[dict[str, Any]]) -> str:
    """Return the section on figures that were to become better and did not."""
    rows = [
        [MEANINGS[key], *(printed(tree["figures"].get(key)) for tree in (trees[0], trees[-1])), why]
        for key, why in MISSED.items()
    ]
    header = ["figure", trees[0]["version"], trees[-1]["version"], "why"]
    lines = [header, ["---", "---:", "---:", "---"], *rows]
    return "\n## Aims missed, and why\n\n" + "".join("| " + " | ".join(line) + " |\n" for line in lines) + OTHER_COUNTS


def page_of(result: dict[str, Any]) -> str:
    """Return the page of stored figures."""
    trees = result["trees"]
    versions = [tree["version"] for tree in trees]
    rows = [[meaning, *(printed(tree["figures"].get(key)) for tree in trees)] for key, meaning in MEANINGS.items()]
    names = sorted({name for tree in trees for name in tree["packages"]})
    columns = {"files": "modules", "largest_folder": "largest folder", "lines": "lines"}
    packages = [
        [f"`{name}/`", *(printed(tree["packages"].get(name, {}).get(key)) for key in columns for tree in trees)]
        for name in names
    ]
    header = [f"{title}, {version}" for title in columns.values() for version in versions]
    return (
        "# The house in figures\n\n"
        f"`{result['command']}`, {result['date']}, over the packages without tests, benchmarks and pages.\n\n"
        + markdown_table(["figure", *versions], rows)
        + "\n## Packages\n\n"
        + markdown_table(["package", *header], packages)
        + missed_aims(trees)
        + COUNTING
    )


def main() -> None:
    """Measure checkouts, or write the page of stored figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkouts", nargs="*", default=[str(ROOT)], metavar="CHECKOUT")
    parser.add_argument("--json", type=Path, help="Store the figures here, and the page beside them.")
    parser.add_argument("--page", type=Path, help="Write the page of these stored figures anew, and measure nothing.")
    options = parser.parse_args()
    if options.page:
        result = json.loads(options.page.read_text(encoding="utf-8"))
        options.page.with_suffix(".md").write_text(page_of(result), encoding="utf-8")
        return
    trees = []
    for name in options.checkouts:
        with checkout_of(name) as checkout:
            trees.append(measure(checkout))
    # The folders of other checkouts say nothing to a reader, their versions do.
    names = [Path(name).resolve() for name in options.checkouts]
    arguments = ["." if name == ROOT else tree["version"] for name, tree in zip(names, trees, strict=True)]
    result = {
        "command": " ".join(["python -m benchmarks.house", *arguments]),
        "date": datetime.datetime.now(tz=datetime.UTC).date().isoformat(),
        "trees": trees,
    }
    print(page_of(result))
    if options.json:
        options.json.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        options.json.with_suffix(".md").write_text(page_of(result), encoding="utf-8")


if __name__ == "__main__":
    main()
