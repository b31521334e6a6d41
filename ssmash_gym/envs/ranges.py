"""Typed ranges: what a scenario draws from. Each draw takes exactly one uniform number in [0, 1).

So a scenario's draws keep their places when one range changes its kind: two scenarios with the same seed share their
random numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Final, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator
from scipy.special import ndtr, ndtri

Number = Annotated[float, Field(allow_inf_nan=False)]
Section = dict[str, Any]  # a section of a configuration, in plain numbers
Extremes = list[tuple[str, Section]]  # sections to try, each with the key that is at fault if it is refused
Uniforms = Callable[[str], float]  # the uniform number that belongs to a named quantity
RANGE_KEYS: Final = frozenset({"constant", "uniform", "choice", "normal"})
_WRITTEN: Final = (
    "a range is a number, {uniform: [low, high]}, {choice: [values]} or "
    "{normal: [mean, deviation], within: [low, high]}"
)


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Constant(_Section):
    """Always the same number; written as the bare number."""

    constant: Number

    def draw(self, u: float) -> float:
        """The value for a uniform number `u` in [0, 1)."""
        return self.constant

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest value."""
        return self.constant, self.constant


class Uniform(_Section):
    """Every number between two bounds is as likely; written ``{uniform: [low, high]}``."""

    uniform: tuple[Number, Number]

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.uniform[0] > self.uniform[1]:
            raise ValueError(f"uniform: {list(self.uniform)}: the first bound must not exceed the second")
        return self

    def draw(self, u: float) -> float:
        """The value for a uniform number `u` in [0, 1)."""
        low, high = self.uniform
        return low + u * (high - low)

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest value."""
        return self.uniform


class Choice(_Section):
    """One of a list, each as likely; written ``{choice: [values]}``."""

    choice: Annotated[tuple[Number, ...], Field(min_length=1)]

    def draw(self, u: float) -> float:
        """The value for a uniform number `u` in [0, 1)."""
        return self.choice[int(u * len(self.choice))]

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest value."""
        return min(self.choice), max(self.choice)


class Normal(_Section):
    """Normal, cut off at two bounds; written ``{normal: [mean, deviation], within: [low, high]}``."""

    normal: tuple[Number, Annotated[float, Field(gt=0.0, allow_inf_nan=False)]]
    within: tuple[Number, Number]

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.within[0] >= self.within[1]:
            raise ValueError(f"within: {list(self.within)}: the first bound must be below the second")
        return self

    def draw(self, u: float) -> float:
        """The value for a uniform number `u` in [0, 1)."""
        mean, deviation = self.normal
        low, high = self.within
        first, last = ndtr((low - mean) / deviation), ndtr((high - mean) / deviation)
        return float(np.clip(mean + deviation * ndtri(first + u * (last - first)), low, high))

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest value."""
        return self.within


def _parsed(given: Any) -> Any:
    """A bare number becomes a `Constant`; a mapping is recognised by its key.

    Raises:
        ValueError: It is no range.
    """
    if isinstance(given, Constant | Uniform | Choice | Normal):
        return given
    if isinstance(given, int | float) and not isinstance(given, bool):
        return Constant(constant=given)
    if isinstance(given, Mapping):
        for key, kind in (("constant", Constant), ("uniform", Uniform), ("choice", Choice), ("normal", Normal)):
            if key in given and set(given) <= set(kind.model_fields):
                return _made(kind, given)
    raise ValueError(f"{given!r} is no range; {_WRITTEN}")


def _made(kind: type[BaseModel], given: Mapping[str, Any]) -> Any:
    """The range, or its first mistake in a few words."""
    try:
        return kind.model_validate(dict(given))
    except ValidationError as error:
        message = error.errors(include_url=False)[0]["msg"].removeprefix("Value error, ")
        raise ValueError(f"{dict(given)!r}: {message[:1].lower() + message[1:]}") from None


Range = Annotated[Constant | Uniform | Choice | Normal, BeforeValidator(_parsed)]


def within(low: float, high: float) -> Any:
    """A validator for a field: all that the range may give must lie between `low` and `high`."""

    def check(given: Any) -> Any:
        found = _parsed(given)
        least, greatest = found.bounds
        if least < low or greatest > high:
            raise ValueError(f"values from {least:g} to {greatest:g} are asked for, allowed are {low:g} to {high:g}")
        return found

    return BeforeValidator(check)
