"""What a page may say to the server. Anything else is counted and dropped: it never reaches the simulation."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

Share = Annotated[float, Field(ge=-1.0, le=1.0, allow_inf_nan=False)]
Sequence = Annotated[int, Field(ge=0, lt=2**53)]


class Message(BaseModel):
    """A message: frozen, no key but its own, and no text where a number belongs."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Plain(Message):
    """A wish without numbers.

    ``take``, ``release``: the driver's role. ``start``: the episode, after a countdown. ``again``, ``next``: get the
    same sea, or another one, ready. ``abort``: break the episode off. ``review``: the finished episode beside the
    policy's. ``schema``: the form.
    """

    type: Literal["take", "release", "start", "again", "next", "abort", "review", "schema"]


class Command(Message):
    """The driver's claw command; sent all the time while driving, also when it is zero."""

    type: Literal["command"]
    sequence: Sequence = Field(description="rises from message to message")
    stamp_ms: Annotated[float, Field(ge=0.0, lt=1e15, allow_inf_nan=False)] = Field(description="page's clock [ms]")
    along: Share = Field(description="claw velocity along the track, as a share of its greatest")
    across: Share = Field(description="the same across it, to starboard")
    device: Literal["keyboard", "gamepad", "stick", ""] = Field("", description="what was moved last")
    shown: Annotated[int, Field(ge=-1, lt=2**31)] = Field(-1, description="newest control step that has been drawn")


class Drive(Message):
    """Hand the claw to the policy, or take it over."""

    type: Literal["drive"]
    by: Literal["person", "policy"]


class Inputs(Message):
    """Names that stand below, and what is changed of them; see `form.checked`."""

    type: Literal["configure", "yaml"]
    base: dict[str, str] = {}
    changes: dict[str, dict[str, Any]] = {}


Known = Plain | Command | Drive | Inputs
_READER: Final[TypeAdapter[Known]] = TypeAdapter(Annotated[Known, Field(discriminator="type")])


def read(text: str | bytes) -> Known | None:
    """The message that a page has sent; None where it is none."""
    try:
        return _READER.validate_json(text)
    except (ValidationError, ValueError, RecursionError):
        return None
