"""One manoeuvre through all systems, run once for all tests."""

from __future__ import annotations

import pytest

from ssmash_gym.assets import asset_path
from ssmash_gym.cases import Case, History, load_case, run_case
from ssmash_gym.systems import apply, load_system
from ssmash_gym.systems.additive import Parts, parts_of


@pytest.fixture(scope="session")
def rolling_traverse() -> Case:
    return load_case(asset_path("configs", "systems", "cases", "rolling_traverse.yaml"))


class Runs(dict[str, History]):
    """What each system does with a case, in its own numbers (a scaled one at its scale); run when first asked for."""

    def __init__(self, case: Case) -> None:
        super().__init__()
        self.case = case

    def __missing__(self, name: str) -> History:
        self[name] = run_case(apply(load_system(name), self.case))
        return self[name]


@pytest.fixture(scope="session")
def runs(rolling_traverse: Case) -> Runs:
    return Runs(rolling_traverse)


@pytest.fixture(scope="session")
def parts(rolling_traverse: Case) -> dict[float, Parts]:
    """The manoeuvre and its two parts at full scale and at one tenth."""
    return {scale: parts_of(rolling_traverse, scale) for scale in (1.0, 0.1)}
