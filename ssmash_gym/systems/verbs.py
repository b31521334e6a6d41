"""`ssmash systems`: a case through the other systems of the thesis, as a picture and a table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final

import tyro
from rich.console import Console
from rich.markdown import Markdown

from ssmash_gym.assets import asset_path
from ssmash_gym.cases import Case, load_case
from ssmash_gym.errors import ConfigurationError, SolverError, require
from ssmash_gym.files import whole_files
from ssmash_gym.progress import progress_bar
from ssmash_gym.systems.additive import Parts, has_parts, parts_of, parts_table
from ssmash_gym.systems.comparison import compare, systems_table
from ssmash_gym.systems.description import load_system, system_names
from ssmash_gym.systems.models import why_not_scaled
from ssmash_gym.systems.picture import NEEDS_MATPLOTLIB, draw_parts, draw_systems

MODEL_SCALE: Final = 0.1


def systems(
    case: tyro.conf.Positional[str],
    names: tuple[str, ...] = (),
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("systems"),
) -> None:
    """Run a case through the full model and the other systems; write systems_CASE.png and systems_CASE.md.

    Where deck and claw both move, systems_CASE_parts.png and a further table show what each of the two does alone.

    Args:
        case: A case of configs/manoeuvres (1a to 2c), one of configs/systems/cases, or a YAML file.
        names: Systems, or YAML files of them; all of the catalogue unless given.
        out: Folder to write to.

    Raises:
        ConfigurationError: The case or a system is refused; nothing has been written.
        ImportError: Matplotlib is missing.
    """
    require("matplotlib", NEEDS_MATPLOTLIB)
    chosen = case_called(case)
    for name in names:
        load_system(name)
    if out.exists() and not out.is_dir():
        raise ConfigurationError(f"--out {out} is refused: it is a file, and a folder is needed.")
    console = Console()
    stem = chosen.name.lower()
    with progress_bar(f"case {chosen.name}") as advance:
        done = compare(chosen, names or system_names(), advance)
        if not done.histories:
            raise ConfigurationError(next(iter(done.refusals.values())))
        parts, missing = parts_at(chosen) if has_parts(chosen) else ({}, [])
    text = f"# Case {chosen.name}: {chosen.title}\n\n{systems_table(done)}"
    if parts:
        text += f"\nIn-plane probe load, deck motion and traverse apart:\n\n{parts_table(parts)}"
    text += "".join(f"\n{sentence}\n" for sentence in missing)
    out.mkdir(parents=True, exist_ok=True)
    picture, table, split = (out / f"systems_{stem}{end}" for end in (".png", ".md", "_parts.png"))
    with whole_files([picture, table, *([split] if parts else [])]) as staged:
        draw_systems(staged[picture], done)
        staged[table].write_text(text, encoding="utf-8", newline="\n")
        if parts:
            draw_parts(staged[split], parts)
    console.print(Markdown(text))
    console.print(f"Written: {', '.join(str(path) for path in staged)}")


def parts_at(case: Case) -> tuple[dict[str, Parts], list[str]]:
    """The parts of a case at full scale and, where it can be scaled, at one tenth; a sentence for each not there."""
    parts, missing = {}, []
    for title, scale in (("full scale", 1.0), ("one tenth, told at full scale", MODEL_SCALE)):
        if scale != 1.0 and why_not_scaled(case) is not None:
            continue
        try:
            parts[title] = parts_of(case, scale)
        except (ConfigurationError, SolverError) as error:
            missing.append(f"No parts of {case.name} ({title}): {' '.join(str(error).split()).rstrip('.')}.")
    return parts, missing


def case_called(name: str) -> Case:
    """A case by its name in ``configs/systems/cases``, by its name among the manoeuvres, or from a file.

    Raises:
        ConfigurationError: There is no such case, or it is refused.
    """
    for path in asset_path("configs", "systems", "cases").glob("*.yaml"):
        if path.stem == name.lower():
            return load_case(path)
    return load_case(name)
