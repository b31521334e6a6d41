"""`ssmash run` and `ssmash convert`: the thesis' files, and cases in YAML."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import tyro

from ssmash_gym.errors import ConfigurationError, ConfigurationWarning
from ssmash_gym.progress import progress_bar

if TYPE_CHECKING:
    from ssmash_gym.cases import Case, History
    from ssmash_gym.thesis_files.writing import Written

Solver = Literal["file", "engine", "adams", "gear", "automatic", "dop853"]
YAML: Final = (".yaml", ".yml", ".json")
LONG_RUN_S: Final = 5.0  # simulated; from here on a bar shows the progress
RECORDS: Final = ("deck", "claw")


@dataclass(frozen=True)
class Source:
    """A case and what is to be said of it.

    Attributes:
        case: The case.
        document: Its document.
        rows_in_memory: Line 3 of SOLUTION.INP; None for a case in YAML.
        defaults: What was taken because no file says it.
        remarks: What else is to be known.
    """

    case: Case
    document: dict[str, Any]
    rows_in_memory: int | None
    defaults: tuple[str, ...]
    remarks: tuple[str, ...]

    @property
    def said(self) -> tuple[str, ...]:
        """Defaults and remarks in lines."""
        head = ("taken because no file says it:",) if self.defaults else ()
        return (*head, *(f"  {default}" for default in self.defaults), *self.remarks)


def run(case_dir: Annotated[Path, tyro.conf.Positional], out: Path | None = None, solver: Solver = "file") -> None:
    """Run a case and write run.out, state.out, aux.out and a recording (Parquet).

    The case is a folder with heli.inp, initials.inp, solution.inp and prescribed.inp, and rsd_pos.inp and shipmo.inp
    where prescribed.inp asks for them, laid out as in appendix A of Léveillé (2013); or a case in YAML. All four files
    are written when the run has come to its end, or none.

    Args:
        case_dir: Folder of the thesis' files, a case file (YAML), or the name of a case that comes with the package.
        out: Folder for the output; unless given, `out` in the folder, or `<name>_out` beside the case file.
        solver: file takes what the case says (line 6 of solution.inp: 1 Adams, 2 Gear, 3 automatic); engine is the
            compiled fixed-step engine; the others are SciPy's.

    Raises:
        ConfigurationError: A file or a number is refused, or the run does not come to its end; nothing is written.
    """
    from ssmash_gym.thesis_files.conditions import ROWS_IN_MEMORY
    from ssmash_gym.thesis_files.outputs import NAMES, write_outputs

    target = out if out is not None else default_out(case_dir)
    if target.exists() and not target.is_dir():
        raise ConfigurationError(f"--out {target} is refused: this is a file, expected a folder.")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ConfigurationWarning)
        source = load(case_dir)
        case = source.case if solver == "file" else source.case.changed({"solution.solver": solver})
        told = tell(source, case)
        with made(target, keep=False):
            pass  # a place that cannot be is refused before the run
        history = ended(case, case_dir)
        told += dict.fromkeys(str(warning.message) for warning in caught)
    for line in told:
        print(line)
    with made(target):
        write_outputs(history, target, source.rows_in_memory or int(ROWS_IN_MEMORY))
    print_summary(history)
    print(f"{', '.join(NAMES)} in {target}: {history.time_s.size} rows")


def convert(
    source: Annotated[Path, tyro.conf.Positional],
    out: Annotated[Path, tyro.conf.Positional],
    sidecar: bool = True,
    overwrite: bool = False,
) -> None:
    """Turn a folder of the thesis' files into a case in YAML, or a case into such a folder.

    Args:
        source: Folder of the thesis' files, a case file (YAML), or the name of a case that comes with the package.
        out: The case file (its name ends in .yaml, .yml or .json) to a folder, or the folder to a case.
        sidecar: Write what the files cannot hold into beyond_thesis.yaml beside them; without it a case that needs it
            is refused.
        overwrite: Replace files that are there.

    Raises:
        ConfigurationError: The case, a file or the place is refused; nothing is written.
    """
    from ssmash_gym.thesis_files.kept import KEPT
    from ssmash_gym.thesis_files.writing import write_case

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ConfigurationWarning)
        given = load(source)
        if source.is_dir():
            write_yaml_case(given.document, out, overwrite)
        elif out.suffix.lower() in YAML:
            raise ConfigurationError(
                f"{out}: expected a folder for the files of {source}, found the name of a case file."
            )
        else:
            written = write_case(given.document, out, sidecar=sidecar, overwrite=overwrite)
    for line in (*given.said, *dict.fromkeys(str(warning.message) for warning in caught)):
        print(line)
    if source.is_dir():
        kept = [
            f"{file} {line.replace('_', ' ')}" for file, rows in given.document.get(KEPT, {}).items() for line in rows
        ]
        print(f"{out}: case {given.case.name}" + (f"; kept for the way back: {', '.join(kept)}" if kept else ""))
        return
    for line in listing(written):
        print(line)


# --- reading -------------------------------------------------------------------------------------------------------


def load(given: Path) -> Source:
    """The case of a folder, a case file or a name.

    Raises:
        ConfigurationError: It is refused.
    """
    from ssmash_gym.cases import case_document, load_case
    from ssmash_gym.document import read_yaml
    from ssmash_gym.thesis_files.case import case_of, read_folder
    from ssmash_gym.thesis_files.kept import KEPT

    if given.is_dir():
        reading = read_folder(given)
        rows = int(reading.folder.numbers["solution"][2][0])
        return Source(reading.case, reading.document, rows, reading.defaults, reading.remarks)
    if given.suffix.lower() not in YAML:
        if given.exists() or len(given.parts) > 1:
            raise ConfigurationError(f"{given}: expected a folder of the thesis' files or a case file in YAML.")
        case = load_case(str(given))
        return Source(case, case_document(case), None, (), ())
    try:
        text = given.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigurationError(f"{given}: cannot be read ({error.strerror or error}).") from None
    except UnicodeDecodeError:
        raise ConfigurationError(f"{given}: this is not a text in UTF-8.") from None
    case, kept = case_of(read_yaml(text, str(given)), str(given), given.parent.resolve())
    return Source(case, {**case_document(case), **({KEPT: kept} if kept else {})}, None, (), ())


def default_out(given: Path) -> Path:
    """Where the output goes unless it is said."""
    if given.is_dir():
        return given / "out"
    return given.parent / f"{given.stem}_out"


def tell(source: Source, case: Case) -> list[str]:
    """What is run, in lines."""
    solution = case.solution
    span = f"{solution.start_s:g} to {solution.end_s:g} s, a row every {solution.output_step_s:g} s"
    accuracy = (
        "" if solution.solver == "engine" else f", relative tolerance {solution.rtol:g}, absolute {solution.atol:g}"
    )
    lines = [f"case {case.name}: {span}, solver {solution.solver}{accuracy}"]
    if case.title:
        lines.append(case.title)
    if case.reconstructed:
        lines.append(f"reconstructed: {case.reconstructed}")
    return lines + list(source.said)


# --- running -------------------------------------------------------------------------------------------------------


def ended(case: Case, source: Path) -> History:
    """The history of a case that came to its end.

    Raises:
        ConfigurationError: It did not.
    """
    from ssmash_gym.cases import run_case

    try:
        long = case.solution.end_s - case.solution.start_s >= LONG_RUN_S
        with progress_bar(f"case {case.name}", shown=long) as progress:
            history = run_case(case, progress)
    except ConfigurationError as error:
        raise (error if str(source) in str(error) else ConfigurationError(f"{source}: {error}")) from None
    except RuntimeError as error:
        raise ConfigurationError(f"{source}: the run is given up: {error}; nothing is written.") from None
    if history.diverged is not None:
        raise ConfigurationError(f"{source}: {history.diverged}; nothing is written.")
    return history


@contextmanager
def made(folder: Path, keep: bool = True) -> Iterator[None]:
    """A folder that is made, and taken away again when the block does not end well, or it is not to be kept.

    Raises:
        ConfigurationError: It cannot be made or written to.
    """
    new = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".ssmash-", dir=folder):
            pass  # it can be written to
        yield
        if not keep:
            take_away(new)
    except BaseException as error:
        take_away(new)
        if isinstance(error, OSError):
            raise ConfigurationError(f"{folder}: cannot be written ({error.strerror or error}).") from None
        raise


def take_away(folders: Sequence[Path]) -> None:
    """Remove folders that are empty, the innermost first."""
    for path in folders:
        if path.is_dir() and not any(path.iterdir()):
            path.rmdir()


def print_summary(history: History) -> None:
    """Print run time and peaks."""
    from rich.console import Console
    from rich.table import Table

    stations = ("auxiliary", "right", "left")
    table = Table(title=f"peaks of case {history.case.name}", title_justify="left")
    table.add_column("")
    for name in stations:
        table.add_column(name, justify="right")
    rows: Sequence[tuple[str, str, float]] = (
        ("tire vertical load, kN", "vertical_load", 1e-3),
        ("tire lateral load, kN", "lateral_load", 1e-3),
        ("tire vertical deflection, mm", "tire_vertical_deflection_largest", 1e3),
        ("tire lateral deflection, mm", "tire_lateral_deflection_largest", 1e3),
        ("suspension compression, mm", "compression", 1e3),
    )
    for label, channel, scale in rows:
        table.add_row(label, *(f"{scale * history.largest(f'{name}_{channel}'):.2f}" for name in stations))
    console = Console()
    console.print(table)
    probe = 1e-3 * history.largest("probe_in_plane")
    used = f", {history.evaluations} right-hand sides" if history.evaluations else ""
    console.print(
        f"probe, in plane: {probe:.2f} kN; run time {history.wall_s:.2f} s, solver {history.solver}{used}",
        highlight=False,
    )


# --- converting ----------------------------------------------------------------------------------------------------


def write_yaml_case(document: dict[str, Any], out: Path, overwrite: bool) -> None:
    """Write a case file; records and a helicopter's file are named from where it lies.

    Raises:
        ConfigurationError: The name is refused.
    """
    import json

    from ssmash_gym.document import write_yaml
    from ssmash_gym.files import write_text

    if out.suffix.lower() not in YAML:
        raise ConfigurationError(f"{out}: the name of a case file must end in {', '.join(YAML)}.")
    if out.is_dir() or (out.exists() and not overwrite):
        raise ConfigurationError(f"{out}: this is there already; give another name, or allow to overwrite.")
    if not out.parent.is_dir():
        raise ConfigurationError(f"{out}: there is no folder {out.parent}.")
    placed = dict(document)
    here = out.parent.resolve()
    for key in RECORDS:
        if placed[key]["type"] == "file":
            placed[key] = {**placed[key], "path": os.path.relpath(placed[key]["path"], here)}
    name = placed["helicopter"]
    if isinstance(name, str) and name.endswith(YAML):
        placed["helicopter"] = os.path.relpath(name, here)
    text = json.dumps(placed, indent=1) + "\n" if out.suffix.lower() == ".json" else write_yaml(placed)
    write_text(out, text)


def listing(written: Written) -> list[str]:
    """What became of a case, in lines."""
    lines = [f"{', '.join(path.name for path in written.files)} in {written.files[0].parent}"]
    where = f"in {written.files[-1].name}" if written.sidecar else "not written"
    for names, why in ((written.beyond, "the files have no place"), (written.words, "the files have no words")):
        if names:
            lines += [f"{where}, for {why}:", *(f"  {name}" for name in names)]
    if written.instead:
        form = "in another form in the files" + (f", as it was {where}" if written.sidecar else "")
        lines += [f"{form}:", *(f"  {name}" for name in written.instead)]
    if written.marks:
        lines.append(f"{where}: where {written.marks} values come from")
    return lines + list(written.notes)
