"""A study in words: what the thesis states, what is simulated, whether it holds; Markdown and JSON."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from ssmash_gym import __version__
from ssmash_gym.analysis.validation.agreement import ENDS_APART_M, LOADS_APART, Agreement
from ssmash_gym.analysis.validation.statements import Finding
from ssmash_gym.analysis.validation.study import Study
from ssmash_gym.cases import case_document

BASES: Final = {"words": "stated", "axis": "printed axis", "expected": "implied"}
UNPUBLISHED: Final = "The thesis' own curves are not published as data; axes and quantities are as printed there."


def title(study: Study) -> str:
    """Title of page and picture."""
    return f"Manoeuvre {study.manoeuvre.name}: {study.manoeuvre.title.lower()}"


def foot(study: Study) -> str:
    """Foot of a picture."""
    solution = study.case.solution
    how = f"engine, {1e3 * solution.substep_s:g} ms" if solution.solver == "engine" else solution.solver
    return (
        f"{study.case.source or 'Léveillé 2013, section 3.2'}, simulated with ssmash_gym {__version__} ({how}). "
        f"{UNPUBLISHED} Configuration: configs/manoeuvres/{study.manoeuvre.case_name}.yaml."
    )


def metadata(study: Study) -> dict[str, str]:
    """Text that goes into a picture's file."""
    words = json.dumps(case_document(study.case))
    return {"Title": title(study), "Software": f"ssmash_gym {__version__}", "Description": words}


# --- Markdown ---------------------------------------------------------------------------------------------------


def summary(study: Study, picture: Callable[[str], str | None], case_file: str, command: str) -> str:
    """The page of a study.

    Args:
        study: The study.
        picture: Link to a picture by its kind: ``""`` the figures, a variant's name, ``systems``; None where it was
            not drawn.
        case_file: Link to the configuration.
        command: The command that makes it.
    """
    lines = [f"# {title(study)}", "", f"{study.case.source}. Configuration: [{study.case.name}]({case_file}).", ""]
    if study.case.reconstructed:
        lines += [f"**Reconstructed:** {' '.join(study.case.reconstructed.split())}", ""]
    lines += [f"*{remark}*\n" for remark in study.remarks]
    lines += ["```sh", command, "```", ""]
    lines += _picture(f"Figures of manoeuvre {study.manoeuvre.name}", picture(""))
    lines += ["## What the thesis states and what is simulated", ""]
    lines += statement_table([f for f in study.findings if not f.statement.needs])
    for variant in study.variants.values():
        lines += [f"## {variant.label[:1].upper()}{variant.label[1:]}", ""]
        lines += [f"{variant.words}\n"] if variant.words else []
        lines += [f"Changed: {_changes(variant.changes)}.", ""]
        lines += _picture(variant.label, picture(variant.name))
        about = [f for f in study.findings if variant.name in f.statement.needs]
        lines += statement_table(about) if about else []
    if study.systems:
        lines += ["## Through other systems of the thesis", ""]
        lines += _picture("The same manoeuvre through other systems", picture("systems"))
    if study.agreements:
        lines += ["## Two integrators", "", *agreement_table([(study.manoeuvre.name, a) for a in study.agreements])]
    return "\n".join(lines).rstrip() + "\n"


def statement_table(findings: Sequence[Finding]) -> list[str]:
    """Findings as a table, and what has to be known of them below it."""
    lines = ["| thesis | where | simulated | holds |", "| --- | --- | --- | --- |"]
    notes: list[str] = []
    for finding in findings:
        statement = finding.statement
        marks = []
        for text in (_basis(statement.basis), _chosen(statement.chosen), statement.note):
            if text:
                notes += [text] if text not in notes else []
                marks.append(str(notes.index(text) + 1))
        told = f"{statement.thesis}" + (f" (taken as: {statement.taken_as})" if statement.taken_as else "")
        mark = f" <sup>{', '.join(marks)}</sup>" if marks else ""
        holds = "yes" if finding.holds else "**no**"
        lines.append(f"| {_cell(told)}{mark} | {_cell(statement.source)} | {_cell(finding.simulated)} | {holds} |")
    lines.append("")
    for k, note in enumerate(notes, start=1):
        lines.append(f"<sup>{k}</sup> {note}" + ("  " if k < len(notes) else ""))
    return [*lines, ""] if notes else lines


def agreement_table(rows: Sequence[tuple[str, Agreement]]) -> list[str]:
    """Agreements of integrators as a table; `rows`: the manoeuvre's name and the agreement."""
    lines = [
        f"Peak loads are asked for within {100 * LOADS_APART:g} %, final positions of the c.g. within "
        f"{1e3 * ENDS_APART_M:g} mm.",
        "",
        "| manoeuvre | beside the engine | largest difference of a peak load | final positions apart | holds |",
        "| --- | --- | --- | --- | --- |",
    ]
    for name, one in rows:
        lines.append(
            f"| {name} | {one.solver}, {one.evaluations} right-hand sides | {100 * one.loads_apart:.3f} % | "
            f"{1e3 * one.apart_m:.3f} mm | {'yes' if one.holds else '**no**'} |"
        )
    return [*lines, ""]


def overview(studies: Sequence[Study], page: Callable[[str], str]) -> list[str]:
    """All studies as a table: statements that hold, and those that do not; `page` links to a page by its manoeuvre."""
    lines = ["| manoeuvre | statements that hold | that do not |", "| --- | --- | --- |"]
    for study in studies:
        name, held = study.manoeuvre.name, f"{study.holding} of {len(study.findings)}"
        failing = "; ".join(f"{f.statement.thesis}: {f.simulated}" for f in study.findings if not f.holds)
        lines.append(f"| [{name} {study.manoeuvre.title}]({page(name)}) | {held} | {_cell(failing)} |")
    return [*lines, ""]


def _picture(alternative: str, link: str | None) -> list[str]:
    return [] if link is None else [f"![{alternative}]({link})", ""]


def _basis(basis: str) -> str:
    return {
        "axis": "Read off the printed limits of an axis, which the thesis chose for its own curves.",
        "expected": "Not in the thesis; implied by its model.",
    }.get(basis, "")


def _chosen(chosen: str) -> str:
    return f"Chosen with this in view: {chosen}. That it holds is then no test." if chosen else ""


def _changes(changes: Mapping[str, Any]) -> str:
    return ", ".join(f"`{key}: {value}`" for key, value in changes.items())


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


# --- JSON -------------------------------------------------------------------------------------------------------


def as_json(study: Study) -> dict[str, Any]:
    """The study as JSON."""
    return {
        "manoeuvre": study.manoeuvre.name,
        "title": study.manoeuvre.title,
        "version": __version__,
        "source": study.case.source,
        "reconstructed": study.case.reconstructed,
        "solver": study.case.solution.solver,
        "remarks": list(study.remarks),
        "statements": [_finding(finding) for finding in study.findings],
        "holding": study.holding,
        "variants": {name: dict(variant.changes) for name, variant in study.variants.items()},
        "systems": list(study.systems),
        "integrators": [_agreement(one) for one in study.agreements],
    }


def _finding(finding: Finding) -> dict[str, Any]:
    statement = finding.statement
    return {
        "thesis": statement.thesis,
        "source": statement.source,
        "basis": BASES[statement.basis],
        "taken_as": statement.taken_as,
        "chosen": statement.chosen,
        "note": statement.note,
        "variants": list(statement.needs),
        "numbers": dict(finding.numbers),
        "simulated": finding.simulated,
        "holds": finding.holds,
    }


def _agreement(one: Agreement) -> dict[str, Any]:
    peaks = {name: {"own_N": own, "other_N": other} for name, (own, other) in one.peaks.items()}
    return {
        "solver": one.solver,
        "peaks": peaks,
        "loads_apart": one.loads_apart,
        "final_positions_apart_m": one.apart_m,
        "evaluations": one.evaluations,
        "holds": one.holds,
    }
