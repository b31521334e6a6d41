"""Who holds the claw: one page at most, and whether a person or the policy drives it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

Hand = Literal["person", "policy"]


@dataclass
class Roles:
    """Pages that are connected, and the driver among them.

    Attributes:
        pages: Numbers of the pages that are connected.
        driver: The one that holds the driver's role; None: nobody.
        by: Whose commands count. With ``person`` and no driver the claw stands still.
    """

    by: Hand = "person"
    pages: set[int] = field(default_factory=set)
    driver: int | None = None

    def join(self, page: int) -> None:
        """A page has been opened; it watches."""
        self.pages.add(page)

    def leave(self, page: int) -> bool:
        """A page is gone, and with it its role; returns whether it was the driver."""
        self.pages.discard(page)
        return self.release(page)

    def take(self, page: int) -> bool:
        """Give a page the driver's role; returns whether it has it now."""
        if self.driver is None and page in self.pages:
            self.driver = page
        return self.driver == page

    def release(self, page: int) -> bool:
        """Take the role from a page; returns whether it had it."""
        had = self.driver is not None and self.driver == page
        if had:
            self.driver = None
        return had

    def message(self) -> dict[str, object]:
        """What every page is told."""
        by = self.by if self.by == "policy" or self.driver is not None else "none"
        viewers = len(self.pages) - (self.driver is not None)
        return {"type": "roles", "driver": self.driver, "viewers": viewers, "by": by}
