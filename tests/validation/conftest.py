"""Runs of the manoeuvres, made once."""

from __future__ import annotations

import functools
from collections.abc import Callable

import pytest

from ssmash_gym.analysis.validation.manoeuvres import Manoeuvre, manoeuvre_named
from ssmash_gym.analysis.validation.spatial import SPATIAL
from ssmash_gym.analysis.validation.study import Study, study


@functools.cache
def made(name: str) -> Study:
    return study(manoeuvre_named(name))


@pytest.fixture(params=SPATIAL, ids=lambda manoeuvre: manoeuvre.name)
def spatial(request: pytest.FixtureRequest) -> Manoeuvre:
    return request.param


@pytest.fixture
def studied() -> Callable[[str], Study]:
    return made
