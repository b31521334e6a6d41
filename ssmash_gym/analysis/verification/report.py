"""What a person, and what a program, sees of the verification table and of the identification."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.table import Table

from ssmash_gym.analysis.verification.identification import Fit, Prediction
from ssmash_gym.analysis.verification.refit import Identification
from ssmash_gym.analysis.verification.table import STATUSES, PrintedRow
from ssmash_gym.analysis.verification.trials import Result, Verification
from ssmash_gym.assets import asset_path

HEADINGS: Final = ("case", "quantity", "expected", "printed", "simulated", "difference", "tolerance", "pass", "status")
WIDTH: Final = 140  # of what is printed into a file
STRONG: Final = 0.9  # correlation from which two numbers are told to go together
Lines = list[list[str]]


def json_text(verification: Verification) -> str:
    """The rows as one JSON object."""
    return json.dumps({"rows": [_json_row(verification, result) for result in verification.results]}, indent=1)


def _json_row(verification: Verification, result: Result) -> dict[str, Any]:
    row = result.row
    return {
        "case": result.trial,
        "quantity": row.quantity,
        "thesis": row.printed,
        "simulated": result.simulated,
        "tolerance": row.tolerance,
        "status": row.status,
        "difference": result.difference,
        "pass": result.passed,
        "expected": row.expected,
        "as_expected": result.as_expected,
        "corrected": row.corrected,
        "reason": row.reason or None,
        "tolerance_from": row.why or None,
        "configuration": f"{shown_path(verification.table.path)}: trials.{result.trial}",
    }


def shown_path(path: Path) -> str:
    """A path as the checkout and the package have it: from ``configs`` on."""
    root = asset_path("configs").parent
    return path.relative_to(root).as_posix() if path.is_relative_to(root) else str(path)


def _plain(value: float, tolerance: float) -> str:
    """A number with the digits that its tolerance makes worth reading; no minus before zero."""
    digits = int(np.clip(np.ceil(-np.log10(tolerance)) + 1, 0, 6))
    text = f"{value:.{digits}f}"
    return text.lstrip("-") if float(text) == 0.0 else text


def _cells(result: Result) -> list[str]:
    row = result.row
    verdict = {True: "yes", False: "NO", None: "-"}[result.passed]
    corrected = f" (right: {row.corrected:g})" if row.corrected not in (None, row.printed) else ""
    printed = f"{row.printed:g}{corrected}"
    expected = "" if row.expected is None else f"{row.expected:g}" if isinstance(row.expected, float) else row.expected
    return [
        result.trial,
        row.quantity,
        str(expected),
        printed,
        _plain(result.simulated, row.tolerance),
        _plain(result.difference, row.tolerance),
        f"{row.tolerance:g}",
        verdict,
        row.status,
    ]


def counts(verification: Verification) -> list[str]:
    """How many values of which status pass, a line each."""
    lines = []
    for status in STATUSES:
        mine = [result for result in verification.results if result.row.status == status]
        judged = [result for result in mine if result.passed is not None]
        passed = sum(result.passed is True for result in judged)
        rest = f", {len(mine) - len(judged)} with nothing to compare with" if len(judged) < len(mine) else ""
        lines.append(f"{status}: {passed} of {len(judged)} pass{rest}")
    words = [result for result in verification.results if result.as_expected is not None]
    lines.append(f"expected in words: {sum(result.as_expected is True for result in words)} of {len(words)} come so")
    return lines


def faults(verification: Verification) -> list[str]:
    """The faulty values with their reasons, a line each."""
    told = [(result, result.row.reason) for result in verification.results if result.row.status == "faulty"]
    return _together(told, lambda row: f"{row.quantity} {row.printed:g}")


def tolerances(verification: Verification) -> list[str]:
    """Where uncommon tolerances come from, a line each."""
    told = [(result, result.row.why) for result in verification.results if result.row.why]
    return _together(told, lambda row: f"{row.quantity} {row.tolerance:g}")


def _together(told: Sequence[tuple[Result, str]], what: Callable[[PrintedRow], str]) -> list[str]:
    """Rows of one case that have the same to say, in one line."""
    groups: dict[tuple[str, str], list[str]] = {}
    for result, words in told:
        groups.setdefault((result.trial, words), []).append(what(result.row))
    return [f"case {trial}, {', '.join(rows)}: {words}" for (trial, words), rows in groups.items()]


def bands(verification: Verification) -> dict[str, tuple[list[str], Lines]]:
    """For each trial that is varied: headings and lines, the trial itself first."""
    found: dict[str, tuple[list[str], Lines]] = {}
    for key in dict.fromkeys(varied.trial for varied in verification.varied):
        own = [result for result in verification.results if result.trial == key]
        tolerance = {result.row.quantity: min(result.row.tolerance, 0.1) for result in own}
        lines = [["as configured", *(_plain(result.simulated, tolerance[result.row.quantity]) for result in own)]]
        for varied in verification.varied:
            if varied.trial == key:
                values = [_plain(varied.values[name], step) for name, step in tolerance.items()]
                lines.append([varied.label, *values])
        found[key] = ["variation", *tolerance], lines
    return found


def notes(verification: Verification) -> list[str]:
    """What else must be known of a trial, a line each."""
    shown = dict.fromkeys(result.trial for result in verification.results)
    trials = verification.table.trials
    return [f"case {key}: {trials[key].file.note}" for key in shown if trials[key].file.note]


def links(verification: Verification) -> list[str]:
    """Where the configurations are."""
    table = verification.table
    return [
        f"trials: {shown_path(table.path)}, by the number of the case; inputs the thesis does not print: "
        f"{shown_path(table.inputs_path)}",
        f"helicopter: {verification.helicopter}",
    ]


def show(console: Console, verification: Verification) -> None:
    """Print the table; a file or a pipe gets it in full width."""
    if not console.is_terminal:
        console = Console(width=WIDTH)
    table = verification.table
    shown = Table(title=table.file.title, caption=table.file.source)
    for heading in HEADINGS:
        shown.add_column(heading, justify="left" if heading in ("quantity", "expected", "status") else "right")
    before = None
    for result in verification.results:
        if before not in (None, result.trial):
            shown.add_section()
        before = result.trial
        style = "red" if result.passed is False else "yellow" if result.row.status == "faulty" else None
        shown.add_row(*_cells(result), style=style)
    console.print(shown)
    for title, lines in _sections(verification):
        console.print(f"\n[bold]{title}[/bold]")
        for line in lines:
            console.print(f"  {line}", highlight=False)
    for key, (headings, cells) in bands(verification).items():
        console.print()
        band = Table(title=f"Case {key}: what the thesis leaves open", box=None)
        for heading in headings:
            band.add_column(heading, justify="left" if heading == "variation" else "right")
        for row in cells:
            band.add_row(*row)
        console.print(band)


def _sections(verification: Verification) -> list[tuple[str, list[str]]]:
    found = [
        ("How many pass", counts(verification)),
        ("Faulty values", faults(verification)),
        ("Notes", notes(verification)),
        ("Tolerances of trends", tolerances(verification)),
        ("Configurations", links(verification)),
    ]
    return [(title, lines) for title, lines in found if lines]


def markdown(verification: Verification) -> str:
    """The table as the pages of the documentation have it."""
    parts = [_markdown_table(HEADINGS, [_cells(result) for result in verification.results])]
    for title, lines in _sections(verification):
        parts.append("\n".join([f"{title}:", "", *(f"- {line}" for line in lines)]))
    for key, (headings, cells) in bands(verification).items():
        parts.append(f"Case {key}, what the thesis leaves open:\n\n{_markdown_table(headings, cells)}")
    return "\n\n".join(parts)


def _markdown_table(headings: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    rows = [list(headings), ["---"] * len(headings), *lines]
    return "\n".join("| " + " | ".join(_code(cell) for cell in cells) + " |" for cells in rows)


def _code(cell: str) -> str:
    """A name as code, anything else as it is."""
    return f"`{cell}`" if "_" in cell and " " not in cell else cell


# --- identification ----------------------------------------------------------------------------------------


def identification_tables(found: Identification) -> list[tuple[str, list[str], Lines]]:
    """Title, headings and lines of everything that the identification has to say."""
    tables: list[tuple[str, list[str], Lines]] = [
        ("Identified numbers", ["number", "value", "sd", "bounds", "meaning"], _value_lines(found.fit)),
        ("Residuals", list(_RESIDUALS), _rest_lines(found.fit)),
        ("Numbers that go together", ["number", "with", "correlation"], _pair_lines(found.fit)),
    ]  # fmt: skip
    if found.predictions:
        headings = ["case left out", "quantity", "printed", "predicted", "error", "sd", "chi2 of the rest"]
        tables.append(("Predictions of cases left out", headings, [_prediction_cells(p) for p in found.predictions]))
    if found.variants:
        tables.append(("Other assumptions", ["assumption", "chi2", *(_SHOWN.values())], _variant_lines(found)))
    return tables


_RESIDUALS: Final = ("case", "quantity", "printed", "fitted", "difference", "sigma", "over sigma")
_SHOWN: Final = {
    "nose_x_m": "nose x [m]",
    "main_x_m": "main x [m]",
    "half_track_m": "half track [m]",
    "nose_foot_m": "nose foot [m]",
    "nose_tire_Pa": "nose tire [MPa]",
    "main_tire_Pa": "main tire [MPa]",
    "pressure_point_z_m": "CP z [m]",
    "cg_shift_m": "c.g. shift [m]",
}


def _value_lines(fit: Fit) -> Lines:
    lines = []
    for p in fit.parameters:
        bound = ", on it" if p.name in fit.at_bounds else ""
        lines.append([
            p.name, f"{fit.values[p.name]:.6g}", f"{fit.deviations[p.name]:.2g}", f"{p.low:g} to {p.high:g}{bound}",
            p.meaning + (f" (input of case {p.trial})" if p.trial else ""),
        ])  # fmt: skip
    return lines


def _rest_lines(fit: Fit) -> Lines:
    lines = []
    for (trial, row), residual in zip(fit.rows, fit.residuals, strict=True):
        assert row.sigma is not None
        difference = float(residual) * row.sigma
        cells = [_plain(row.printed + difference, row.tolerance / 10.0), _plain(difference, row.tolerance / 10.0)]
        lines.append([trial, row.quantity, f"{row.printed:g}", *cells, f"{row.sigma:g}", f"{residual:.2f}"])
    return lines


def _pair_lines(fit: Fit) -> Lines:
    names = [p.name for p in fit.parameters]
    pairs = [(abs(fit.correlation[i, j]), i, j) for i in range(len(names)) for j in range(i)]
    strong = sorted((pair for pair in pairs if pair[0] > STRONG), reverse=True)
    return [[names[i], names[j], f"{fit.correlation[i, j]:.3f}"] for _, i, j in strong]


def _prediction_cells(p: Prediction) -> list[str]:
    aim = p.row.printed if p.row.aim is None else p.row.aim
    fine = p.row.tolerance / 10.0
    return [
        p.trial, p.row.quantity, f"{aim:g}" + (" (corrected)" if p.row.corrected is not None else ""),
        _plain(p.predicted, fine), _plain(p.error, fine), _plain(p.deviation, fine), f"{p.chi2:.1f}",
    ]  # fmt: skip


def _variant_lines(found: Identification) -> Lines:
    lines = []
    for label, fit in (("as chosen", found.fit), *found.variants):
        cells = []
        for name in _SHOWN:
            scale = 1e-6 if name.endswith("_Pa") else 1.0
            cells.append(f"{scale * fit.values[name]:.4g}" + (" (bound)" if name in fit.at_bounds else ""))
        lines.append([label, f"{fit.chi2:.1f}", *cells])
    return lines


def show_identification(console: Console, found: Identification) -> None:
    """Print it; a file or a pipe gets it in full width."""
    if not console.is_terminal:
        console = Console(width=WIDTH)
    for title, headings, lines in identification_tables(found):
        if not lines:
            continue
        table = Table(title=title)
        for heading in headings:
            table.add_column(heading, justify="left" if heading in _LEFT else "right")
        for cells in lines:
            table.add_row(*cells)
        console.print(table)
    console.print(chi2_line(found.fit), highlight=False)


_LEFT: Final = ("number", "quantity", "meaning", "with", "assumption")


def chi2_line(fit: Fit) -> str:
    """The fit in one line."""
    return (
        f"chi2 {fit.chi2:.1f} of {len(fit.rows)} values with {len(fit.parameters)} free numbers; the loads of cases "
        f"1, 2, 3 add up to known weights, so {len(fit.rows) - 3} values are independent"
    )


def identification_markdown(found: Identification) -> str:
    """The same for the pages of the documentation."""
    parts = [chi2_line(found.fit) + "."]
    for title, headings, lines in identification_tables(found):
        if lines:
            parts.append(f"{title}:\n\n{_markdown_table(headings, lines)}")
    return "\n\n".join(parts)
