"""The documentation's pages and pictures of the manoeuvres: ``python -m ssmash_gym.analysis.validation.pages docs``.

Each manoeuvre is run as its file says, by a second integrator, with its suspects, and 2C without the coupling of
friction and twist; nothing on the pages is written by hand.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from ssmash_gym.analysis.validation.manoeuvres import manoeuvres
from ssmash_gym.analysis.validation.report import agreement_table, overview, summary
from ssmash_gym.analysis.validation.study import Asked, Study
from ssmash_gym.analysis.validation.verbs import file_name, pictures, run_studies, text_writer
from ssmash_gym.files import whole_files

COMMAND: Final = "python -m ssmash_gym.analysis.validation.pages docs"
SECOND: Final = ("dop853",)
UNCOUPLED: Final = ("2C",)  # manoeuvres that are also shown with friction not coupled with twist


def asked_for(name: str, solvers: Sequence[str] = SECOND) -> Asked:
    """What the documentation shows beside a manoeuvre."""
    return Asked(friction="independent" if name in UNCOUPLED else "", solvers=tuple(solvers), suspects=True)


def page(one: Study) -> str:
    """The page of a manoeuvre."""
    name = one.manoeuvre.name
    drawn = pictures(one)
    options = "".join([" --friction independent" if name in UNCOUPLED else "", " --suspects" if len(drawn) > 1 else ""])
    return summary(
        one,
        lambda kind: f"../images/manoeuvres/{file_name(name, kind)}" if kind in drawn else None,
        f"../../configs/manoeuvres/{one.manoeuvre.case_name}.yaml",
        f"ssmash manoeuvre {name}{options} --solver {' '.join(SECOND)} --out build/{name}",
    )


def write_pages(docs: Path, names: Sequence[str] = ()) -> None:
    """Write pages and pictures.

    Args:
        docs: Folder of the documentation.
        names: Manoeuvres; all of them unless given, and then the table of all too.
    """
    chosen = list(names) or list(manoeuvres())
    studies = run_studies(chosen, asked_for)
    content = {}
    for one in studies:
        name = one.manoeuvre.name
        content[docs / "manoeuvres" / f"{name}.md"] = text_writer(page(one))
        content |= {docs / "images" / "manoeuvres" / file_name(name, k): put for k, put in pictures(one).items()}
    if not names:
        rows = [(one.manoeuvre.name, agreed) for one in studies for agreed in one.agreements]
        lines = ["# All manoeuvres", "", f"Made by `{COMMAND}`.", "", "## Statements", ""]
        lines += overview(studies, lambda name: f"{name}.md")
        lines += ["## Two integrators of different families", "", *agreement_table(rows)]
        content[docs / "manoeuvres" / "overview.md"] = text_writer("\n".join(lines).rstrip() + "\n")
    for path in content:
        path.parent.mkdir(parents=True, exist_ok=True)
    with whole_files(content) as staged:
        for path, put in content.items():
            put(staged[path])


if __name__ == "__main__":
    write_pages(Path(sys.argv[1]), sys.argv[2:])
