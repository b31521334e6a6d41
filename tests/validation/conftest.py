"""Runs of the manoeuvres, made once."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from ssmash_gym.analysis.validation.manoeuvres import Manoeuvre, manoeuvre_named
from ssmash_gym.analysis.validation.spatial import SPATIAL
from ssmash_gym.analysis.validation.study import Study, study
from ssmash_gym.cases import QUANTITIES


@functools.cache
def made(name: str) -> Study:
    return study(manoeuvre_named(name))


@pytest.fixture(params=SPATIAL, ids=lambda manoeuvre: manoeuvre.name)
def spatial(request: pytest.FixtureRequest) -> Manoeuvre:
    return request.param


@pytest.fixture
def studied() -> Callable[[str], Study]:
    return made


@pytest.fixture
def assert_printed_axes() -> Callable[[Sequence[Manoeuvre], dict[str, Any]], None]:
    """The figures of manoeuvres: numbers, time spans and limits as printed, marks at whole steps."""

    def check(manoeuvres: Sequence[Manoeuvre], printed: dict[str, Any]) -> None:
        found = {
            figure.number: (figure.seconds, [panel.limits for panel in figure.panels])
            for manoeuvre in manoeuvres
            for figure in manoeuvre.figures
        }
        assert found == printed
        for manoeuvre in manoeuvres:
            for figure in manoeuvre.figures:
                for panel in figure.panels:
                    assert all(one.quantity in QUANTITIES for one in panel.curves)
                    marks = (panel.limits[1] - panel.limits[0]) / panel.step
                    assert marks == pytest.approx(round(marks)) and 2 <= marks <= 10

    return check
