"""Base of every section of a case."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class CaseSection(BaseModel):
    """Frozen, and strict about its keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")
