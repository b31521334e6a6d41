"""Cases: deterministic runs described in files; verification, validation and the thesis' own files all are cases."""

from ssmash_gym.cases.description import SOLVERS, Case, case_document, case_from, case_names, load_case
from ssmash_gym.cases.quantities import QUANTITIES, Quantity, quantity
from ssmash_gym.cases.run import History, prepared, run_case

__all__ = [
    "QUANTITIES",
    "SOLVERS",
    "Case",
    "History",
    "Quantity",
    "case_document",
    "case_from",
    "case_names",
    "load_case",
    "prepared",
    "quantity",
    "run_case",
]
