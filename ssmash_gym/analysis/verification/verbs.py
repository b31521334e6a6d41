"""`ssmash verify` and `ssmash identify`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import tyro
from rich.console import Console

from ssmash_gym.errors import ConfigurationError


def verify(
    json: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False,
    markdown: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False,
    case: str | None = None,
    helicopter: str | None = None,
    cases_to: Path | None = None,
) -> None:
    """Run the verification trials of Table 3.1 of the thesis and compare every printed value.

    Args:
        json: Print one JSON object with the rows and nothing else.
        markdown: Print the table as the documentation has it.
        case: Only this case, 1 to 15.
        helicopter: Another helicopter than the table's own: a name of the catalogue or a file.
        cases_to: Folder to write the cases to, for `ssmash run`.
    """
    from ssmash_gym.analysis.verification import report
    from ssmash_gym.analysis.verification.table import load_table
    from ssmash_gym.analysis.verification.trials import run_table, write_cases
    from ssmash_gym.vehicle import load_helicopter

    if json and markdown:
        raise ConfigurationError("--json and --markdown are refused together: choose one.")
    table = load_table()
    vehicle = load_helicopter(table.helicopter if helicopter is None else helicopter)
    with _telling("verify") as tell:
        found = run_table(table, vehicle, None if case is None else [case], tell, helicopter or "")
    if cases_to is not None:
        write_cases(table, vehicle, cases_to, None if case is None else [case])
    if json:
        print(report.json_text(found))
    elif markdown:
        print(report.markdown(found))
    else:
        report.show(Console(), found)


def identify(
    out: Path = Path("runs/identify"),
    predictions: bool = True,
    variants: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False,
    warm: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False,
    markdown: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False,
) -> None:
    """Refit the generic tricycle to Table 3.1 and write its file, and the inputs of the trials.

    Args:
        out: Folder for helicopters/generic_tricycle.yaml and verification/case_inputs.yaml; `configs` renews those of
            the checkout.
        predictions: Predict the cases 2, 3, 4, 13, 14, 15, each from a fit without it.
        variants: Also fit under other assumptions about what the table does not determine.
        warm: Start at the present numbers instead of round guesses.
        markdown: Print the tables as the documentation has them.
    """
    from ssmash_gym.analysis.verification import report
    from ssmash_gym.analysis.verification.description import helicopter_text, inputs_text, values_of
    from ssmash_gym.analysis.verification.refit import refit
    from ssmash_gym.analysis.verification.table import load_table, plain
    from ssmash_gym.files import whole_files
    from ssmash_gym.vehicle import load_helicopter

    table = load_table()
    template = load_helicopter(table.helicopter)
    if out.exists() and not out.is_dir():
        raise ConfigurationError(f"--out {out} is refused: it is a file, a folder is needed.")
    start = values_of(template, plain(table.inputs, str(table.inputs_path))) if warm else None
    with _telling("identify") as tell:
        found = refit(table, template, start, leave_out=predictions, vary=variants, tell=tell)
    targets = (
        (out / "helicopters" / f"{template.name}.yaml", helicopter_text(found.helicopter)),
        (out / "verification" / table.inputs_path.name, inputs_text(found.inputs)),
    )
    for path, _ in targets:
        path.parent.mkdir(parents=True, exist_ok=True)
    with whole_files(path for path, _ in targets) as staged:
        for path, text in targets:
            staged[path].write_text(text, encoding="utf-8", newline="\n")
    console = Console()
    if markdown:
        print(report.identification_markdown(found))
        return
    report.show_identification(console, found)
    for path, _ in targets:
        console.print(f"wrote {path}", highlight=False)


@contextmanager
def _telling(verb: str) -> Iterator[Callable[[str], None]]:
    """What is being done, on the error stream while a person looks at it; nothing of it stays."""
    console = Console(stderr=True)
    with console.status(f"{verb} ...") as status:
        yield lambda what: status.update(f"{verb}: {what}")
