"""Pages and README lines of the blind studies: studies of the ledger in, Markdown out, no figure typed by hand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from docs.parts.tables import table
from studies.blind.outcome import MEANING, Outcome
from studies.blind.page import share
from studies.blind.score import Row, by_kind_and_size, coverage, share_of, summarise_spread
from studies.evidence.pools import (
    KINDS,
    RULE,
    Study,
    coverage_rates,
    left_out_rates,
    named_rates,
    settled_rates,
    verdict_rates,
)
from studies.ledger.entries import OWN, STRANGER

SIZES = (
    "Sizes: `nominal` moves the joint by 1 to 5 % of its motion and leaves at least twice the noise after a refit; "
    "`threshold` leaves 0.1 to 0.3 of the noise; `small` is their geometric mean."
)
PICTURE = "blind.png"
PICTURED = f"![Rows: what was hidden; columns: the verdict]({PICTURE})\n"
ENDED = {
    "begun": "begun, never ended",
    "complete": "complete",
    "interrupted": "cut short by hand or by its time",
    "lost": "lost",
}
TRUTHS = {
    OWN: "the project's own virtual device",
    "stranger": "another machine on purpose, whose formulas are not the catalogue's",
}


def file_of(kind: str, truth: str = OWN) -> str:
    """Return the file name of the page of a kind of studies.

    Parameters
    ----------
    kind
        One of `KINDS`; empty for the page of all.
    truth
        Truth of the studies; pools of two truths are never mixed.

    Returns
    -------
    str
        Name of a Markdown file.
    """
    parts = ["blind", kind] if truth == OWN else ["blind", truth, kind or "all"]
    return "_".join(part for part in parts if part) + ".md"


def pages(studies: Sequence[Study]) -> dict[str, str]:
    """Write all pages: for each truth one of everything, and one of each kind of studies.

    Parameters
    ----------
    studies
        All studies of the ledger.

    Returns
    -------
    dict
        Markdown by file name.
    """
    written = {}
    for truth in dict.fromkeys(study.entry["truth"] for study in studies):
        of_truth = [study for study in studies if study.entry["truth"] == truth]
        written[file_of("", truth)] = overview(of_truth, truth)
        for kind in KINDS:
            if of_kind := [study for study in of_truth if study.kind == kind]:
                written[file_of(kind, truth)] = page_of_kind(of_kind, kind)
    return written


def overview(studies: Sequence[Study], truth: str) -> str:
    """Write the page of all studies of one truth.

    Parameters
    ----------
    studies
        Studies of this truth, at least one.
    truth
        Name of the truth.

    Returns
    -------
    str
        Markdown.
    """
    kinds = [kind for kind in KINDS if any(study.kind == kind for study in studies)]
    links = [
        (f"[{KINDS[kind]}]({file_of(kind, truth)})", *_counts([s for s in studies if s.kind == kind])) for kind in kinds
    ]
    parts = [
        "# Blind studies of the search for missing effects\n",
        "A virtual device, with formulas and integrator of its own, hides effects in campaigns; the search sees the "
        "campaigns, the scorer alone the labels. Written by `python -m studies.evidence.run` from `ledger.json` and "
        "the files below `blind/`.\n",
        f"Truth: {TRUTHS.get(truth, truth)}. {_span(studies)}\n",
        f"{RULE}\n",
        "`make blind` enters a study into the ledger before the search sees its first case, and nothing leaves it; "
        "studies that came before the ledger are entered afterwards, from what was stored of them. A series ends where "
        "the program that makes the cases changes.\n",
        "## Kinds of studies\n",
        table(("a study hides", "studies", "lost", "cases", "without the true entry", "with the proposed run"), links),
        f"{_clean_share(_cases(studies))}\n",
        *_pools(studies),
        "\n## By kind of study\n",
        table(
            ("a study hides", "right verdicts", "named exactly, or nothing rightly"),
            [(KINDS[kind], *_right_and_exact(_cases([s for s in studies if s.kind == kind]))) for kind in kinds],
        ),
        *_by_kind_and_size(_cases(studies), truth),
        *_section("What was taken for what", PICTURED if truth == OWN else ""),
        *_coverage(_cases(studies)),
        "\n## Every study\n",
        _list_studies(studies),
    ]  # fmt: skip
    return "\n".join(parts).rstrip() + "\n"


def page_of_kind(studies: Sequence[Study], kind: str) -> str:
    """Write the page of one kind of studies.

    Parameters
    ----------
    studies
        Studies of this kind and of one truth, at least one.
    kind
        One of `KINDS`.

    Returns
    -------
    str
        Markdown.
    """
    cases = _cases(studies)
    parts = [
        f"# Blind studies: {KINDS[kind]}\n",
        "Written by `python -m studies.evidence.run` from `ledger.json` and the files below `blind/`. "
        f"[All studies]({file_of('', studies[0].entry['truth'])}). {_span(studies)}\n",
        f"{RULE}\n",
        *_pools(studies),
        *_by_kind_and_size(cases, studies[0].entry["truth"]),
        "\n## Every study\n",
        _list_studies(studies),
        "\n## Verdicts that were not right\n",
        _wrong(studies, "cases"),
        *_section("Without the true entry: not flagged", _wrong(studies, "left_out")),
        *_section("With the proposed run: not named exactly", _wrong(studies, "settled")),
        *_coverage(cases),
        "\n## Commands\n",
        "\n".join(f"- {study.entry['id']}: `{study.entry['command']}`" for study in studies),
    ]
    return "\n".join(parts).rstrip() + "\n"


def readme_text(studies: Sequence[Study]) -> str:
    """Write the lines of README on the blind studies: of the project's own truth, and of the stranger's.

    Parameters
    ----------
    studies
        All studies of the ledger.

    Returns
    -------
    str
        Five lines of Markdown at most.
    """
    own = [study for study in studies if study.entry["truth"] == OWN]
    cases = _cases(own)
    rates = dict(named_rates(cases) + left_out_rates(_left_out(own)))
    mixed = dict(verdict_rates(_cases([study for study in own if study.kind == "mixed"])))
    exact, among = (
        rates[f"effects of the catalogue hidden: {w}"] for w in ("named exactly", "ambiguous, the truth among")
    )
    flagged, wrong = (
        rates[f"true entry left out: {w}"] for w in ("unlisted or ambiguous", "a wrong name given as certain")
    )
    (_, held), _ = coverage_rates(cases)
    lost = sum(study.entry["outcome"] == "lost" for study in own)
    strange = [study for study in studies if study.entry["truth"] == STRANGER]
    lines = [
        "- A named effect is a claim that is put to the test, on the project's own virtual device: "
        f"[blind studies](docs/results/blind.md), {len(own)} in [the ledger](docs/results/ledger.json) ({lost} of "
        f"them lost), {_dates(own)}. Where all kinds of cases are mixed, {share(mixed['right verdicts'])} verdicts are "
        "right (in brackets Wilson's 95 % interval).",
        "    - Right means: named exactly; ambiguous, with the truth among the alternatives; nothing found where "
        "nothing is hidden; unlisted or ambiguous where the catalogue lacks what is hidden.",
        f"    - Effects that the catalogue has are named exactly in {share(exact)} cases, and among the alternatives "
        f"in {share(among)}. Where nothing is hidden, {share(rates['nothing hidden: something found'])} sets alarm.",
        f"    - With [the true entry left out](docs/results/{file_of('left_out')}), {share(flagged)} are flagged, and "
        f"{share(wrong)} get a wrong name as certain. 95 % intervals of named effects hold the truth in {share(held)}.",
        "    - The search was changed because of these studies, and the catalogue has the formulas that were hidden: a "
        f"machine is harder. {_on_strangers(strange)}".rstrip(),
    ]
    return "\n".join(lines)


def _on_strangers(studies: Sequence[Study]) -> str:
    """Say how the search does on machines whose formulas are not the catalogue's; nothing without such studies."""
    cases = _cases(studies)
    if not cases:
        return ""
    wrong = share_of(cases, lambda o: o.wrong_as_certain)
    right = dict(verdict_rates(cases))["right verdicts"]
    return (
        f"On [a stranger's machine](docs/results/{file_of('', STRANGER)}), whose friction laws and disturbances follow "
        f"other formulas, {share(right)} verdicts are right, and {share(wrong)} tell a wrong name, or not all of "
        "them, as certain."
    )


def _pools(studies: Sequence[Study]) -> list[str]:
    cases, left, settled = _cases(studies), _left_out(studies), [o for s in studies for o in s.settled]
    rows: list[tuple[str, Row]] = []
    if cases:
        rows += verdict_rates(cases) + named_rates(cases) + coverage_rates(cases)
    rows += (left_out_rates(left) if left else []) + (settled_rates(settled) if settled else [])
    closed = summarise_spread(o.closed for o in cases if o.result == "named")
    wall = summarise_spread(o.wall_s for o in cases or left)
    parts = [
        "\n## All together\n",
        table(("counted", "rate"), [(words, share(row)) for words, row in rows if row["n"]]),
    ]
    if closed["n"]:
        parts.append(
            f"Gap closed on unseen runs where named exactly: median {closed['median']:.4f} of {closed['n']}; these "
            "runs take part in the choice of the names.\n"
        )
    if wall["n"]:
        parts.append(
            f"A search takes {wall['median']:.0f} s (median; nine in ten within {wall['p90']:.0f} s) on the machines "
            "of the studies, many of them with other work beside it.\n"
        )
    return parts


def _by_kind_and_size(cases: Sequence[Outcome], truth: str) -> list[str]:
    if not cases:
        return []
    said = SIZES if truth == OWN else ""  # sizes of another truth are its own
    rows = [(r["kind"], r["size"], share(r["right"]), share(r["exact"])) for r in by_kind_and_size(cases)]
    header = ("what a case hides", "size", "right verdict", "named exactly, or nothing rightly")
    return ["\n## By kind and size of the cases\n", table(header, rows), said]


def _coverage(cases: Sequence[Outcome]) -> list[str]:
    rows = [(name, share(row)) for name, row in coverage(cases)["parameters"].items()]
    return _section(
        "Coverage by parameter", table(("parameter", "95 % intervals that hold the truth"), rows) if rows else ""
    )


def _list_studies(studies: Sequence[Study]) -> str:
    rows = []
    for study in studies:
        entry = study.entry
        rows.append(
            (
                entry["id"], entry["date"], entry["git"] or "–", entry["series"] or "–", _word_end(study),
                *_right_and_exact(study.cases), _share_flagged(study), _share_settled(study),
            )
        )  # fmt: skip
    header = (
        "study",
        "date",
        "version",
        "series",
        "ended",
        "right",
        "exact",
        "flagged without the true entry",
        "settled by the run",
    )
    text = table(header, rows)
    lost = [f"- {s.entry['id']}: {s.entry['known']}" for s in studies if "known" in s.entry]
    return text + ("\nLost:\n\n" + "\n".join(lost) + "\n" if lost else "")


def _word_end(study: Study) -> str:
    entry = study.entry
    words = ENDED[entry["outcome"]]
    worked, asked = entry.get("worked_through"), entry["plan"]["cases"]
    counted = f"{words}, {worked} of {asked} cases" if worked is not None else words
    return counted + ("" if entry["entered"] == "before" else "; entered afterwards")


def _right_and_exact(cases: Sequence[Outcome]) -> tuple[str, str]:
    rates = dict(verdict_rates(cases))
    return _short(rates["right verdicts"]), _short(rates["named exactly, or nothing rightly"])


def _share_flagged(study: Study) -> str:
    return _short(left_out_rates(study.left_out)[0][1])


def _share_settled(study: Study) -> str:
    return _short(settled_rates(study.settled)[0][1])


def _short(row: Row) -> str:
    return share(row) if row["n"] else ""


def _wrong(studies: Sequence[Study], name: str) -> str:
    good = {"cases": (), "left_out": ("flagged",), "settled": ("named",)}[name]
    rows = []
    for study in studies:
        for o in getattr(study, name):
            if o.right if name == "cases" else o.result in good:
                continue
            told = f"{o.verdict} {', '.join(o.names)}".strip() + (f" ({o.reason})" if o.reason else "")
            hidden = ", ".join(o.truth) or "nothing"
            rows.append((study.entry["id"], o.case, hidden, o.size, o.joint, f"{told}: {MEANING[o.result]}"))
    if not rows:
        return "None.\n" if any(getattr(study, name) for study in studies) else ""
    return table(("study", "case", "hidden", "size", "joint", "verdict"), rows)


def _section(title: str, text: str) -> list[str]:
    return [f"\n## {title}\n", text] if text else []


def _counts(studies: Sequence[Study]) -> tuple[int, int, int, int, int]:
    lost = sum(study.entry["outcome"] == "lost" for study in studies)
    settled = sum(len(study.settled) for study in studies)
    return len(studies), lost, len(_cases(studies)), len(_left_out(studies)), settled


def _cases(studies: Iterable[Study]) -> list[Outcome]:
    return [outcome for study in studies for outcome in study.cases]


def _left_out(studies: Iterable[Study]) -> list[Outcome]:
    return [outcome for study in studies for outcome in study.left_out]


def _dates(studies: Sequence[Study]) -> str:
    dates = sorted(study.entry["date"] for study in studies)
    return dates[0] if dates[0] == dates[-1] else f"{dates[0]} to {dates[-1]}"


def _clean_share(cases: Sequence[Outcome]) -> str:
    clean = sum(o.kind == "none" for o in cases)
    return (
        f"Of the {len(cases)} cases with the whole catalogue {clean} hide nothing, for some studies ask for such cases "
        "alone: the rate of right verdicts over all studies says less than those by kind of study."
    )


def _span(studies: Sequence[Study]) -> str:
    series = {study.entry["series"] for study in studies} - {None}
    versions = {study.entry["git"] for study in studies}
    return (
        f"{len(studies)} studies, {_dates(studies)}, {len(versions)} versions of the code, {len(series)} series of the "
        "generator."
    )
