"""Other systems of the thesis as settings of this one, laid over any case."""

from ssmash_gym.systems.additive import parts_of
from ssmash_gym.systems.comparison import cases_of, compare, systems_figure, systems_table, told
from ssmash_gym.systems.description import System, load_system, system_from, system_names
from ssmash_gym.systems.models import at_full_scale, scaled_case
from ssmash_gym.systems.overlay import apply, label, why_not
from ssmash_gym.systems.scaling import scaled

__all__ = [
    "System",
    "apply",
    "at_full_scale",
    "cases_of",
    "compare",
    "label",
    "load_system",
    "parts_of",
    "scaled",
    "scaled_case",
    "system_from",
    "system_names",
    "systems_figure",
    "systems_table",
    "told",
    "why_not",
]
