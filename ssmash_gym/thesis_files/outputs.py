"""RUN.OUT, STATE.OUT and AUX.OUT (Léveillé 2013, appendix A), and a recording beside them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Final, TextIO

import numpy as np

from ssmash_gym.files import whole_files
from ssmash_gym.thesis_files.conditions import ROWS_IN_MEMORY
from ssmash_gym.thesis_files.output_layout import AUX, STATE, state_row

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ssmash_gym.cases import History

NAMES: Final = ("run.out", "state.out", "aux.out", "recording.parquet")
FORMAT: Final = "% .12e"


def write_outputs(history: History, folder: Path, rows_in_memory: int = int(ROWS_IN_MEMORY)) -> tuple[Path, ...]:
    """Write the three files and the recording ``recording.parquet``: all of them, or none.

    Args:
        history: The run.
        folder: Folder that exists.
        rows_in_memory: Rows in a block that is printed at once (line 3 of SOLUTION.INP).

    Returns:
        The files.
    """
    paths = tuple(folder / name for name in NAMES)
    with whole_files(paths) as staged:
        run, state, aux, recording = (staged[path] for path in paths)
        prints = _write_table(state, state_table(history), rows_in_memory)
        _write_table(aux, aux_table(history), rows_in_memory)
        run.write_text(f"{history.wall_s:.6f}\n{history.time_s.size - 1}\n{prints}\n", encoding="utf-8", newline="\n")
        history.write(recording)
    return paths


def state_table(history: History) -> NDArray[np.float64]:
    """Columns of STATE.OUT, (m, 35): time, u7 to u18, q8 to q29."""
    return np.stack([history.time_s, *(history.states[state_row(column)] for column in STATE[1:])], axis=1)


def aux_table(history: History) -> NDArray[np.float64]:
    """Columns of AUX.OUT, (m, 10): time, probe force, and by station the tires' mean lateral deflection and load."""
    return np.stack([history.time_s, *(history[column.path] for column in AUX[1:])], axis=1)


def _write_table(path: Path, table: NDArray[np.float64], rows_in_memory: int) -> int:
    """Write the rows in blocks; returns how many there were."""
    blocks = math.ceil(len(table) / rows_in_memory)
    with path.open("w", encoding="utf-8", newline="\n") as file:
        for k in range(blocks):
            _print(file, table[k * rows_in_memory : (k + 1) * rows_in_memory])
    return blocks


def _print(file: TextIO, rows: NDArray[np.float64]) -> None:
    file.writelines(" ".join(FORMAT % number for number in row) + "\n" for row in rows.tolist())
