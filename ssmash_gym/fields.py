"""What every part of a helicopter's description is made of: numbers, vectors, and the strict frozen base."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0.0)]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.0)]
Vector = tuple[Number, Number, Number]
NonNegativeVector = tuple[NonNegative, NonNegative, NonNegative]
Matrix = tuple[Vector, Vector, Vector]

UNIT_NORM_TOLERANCE: Final = 1.0e-6
SYMMETRY_TOLERANCE: Final = 1.0e-9


def refuse(key: str, value: object, allowed: str) -> PydanticCustomError:
    """Make the error of a check that a single field's limits cannot express.

    Args:
        key: Dotted path of the value, from the part that is being checked; may be empty.
        value: What was given.
        allowed: What is allowed, as the rest of a sentence.
    """
    return PydanticCustomError("refused", "{allowed}", {"key": key, "value": value, "allowed": allowed})


def _unit_norm(parameters: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    norm = sum(e * e for e in parameters) ** 0.5
    if abs(norm - 1.0) > UNIT_NORM_TOLERANCE:
        raise refuse("", parameters, f"Euler parameters must have norm 1, these have {norm:.6g}")
    return parameters


def _inertia(tensor: Matrix) -> Matrix:
    """Accept a tensor that a rigid body can have: symmetric, positive definite, triangle inequality."""
    scale = max(abs(entry) for row in tensor for entry in row)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        if abs(tensor[i][j] - tensor[j][i]) > SYMMETRY_TOLERANCE * scale:
            raise refuse(
                "",
                tensor,
                f"an inertia tensor must be symmetric, but entry ({i + 1},{j + 1}) is {tensor[i][j]:g} "
                f"and entry ({j + 1},{i + 1}) is {tensor[j][i]:g}",
            )
    moments = principal_moments(tensor)
    shown = ", ".join(f"{m:.6g}" for m in moments)
    if moments[0] <= 0.0:
        raise refuse("", tensor, f"an inertia tensor must be positive definite, its principal moments are {shown}")
    if moments[0] + moments[1] < moments[2] * (1.0 - SYMMETRY_TOLERANCE):
        raise refuse(
            "",
            tensor,
            "no principal moment of inertia may exceed the sum of the other two (triangle inequality), they are "
            + shown,
        )
    return tensor


def principal_moments(tensor: Matrix) -> tuple[float, float, float]:
    """Principal moments of a symmetric tensor, smallest first [kg m2]."""
    import numpy as np

    smallest, middle, largest = np.linalg.eigvalsh(np.array(tensor))
    return float(smallest), float(middle), float(largest)


EulerParameters = Annotated[tuple[Number, Number, Number, Number], AfterValidator(_unit_norm)]
Inertia = Annotated[Matrix, AfterValidator(_inertia)]


class Part(BaseModel):
    """Base of every part: frozen, and strict about its keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if isinstance(data, Mapping):
            for key in data:
                if key not in cls.model_fields:
                    raise refuse(str(key), data[key], f"the key is unknown here; {_advice(str(key), cls)}")
        return data


def _advice(key: str, part: type[BaseModel]) -> str:
    known = list(part.model_fields)
    close = difflib.get_close_matches(key, known, n=1)
    return f"did you mean {close[0]}?" if close else f"known are {', '.join(known)}"
