"""The newest command of the driver, and how long it counts: a stuck key or a cut line must not drive the claw on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from ssmash_gym.console.messages import Command

EXPIRY_S: Final = 0.25  # without renewal
ZERO_WITHIN_S: Final = 0.3  # of the last renewal: no command acts beyond it, though it holds for a whole interval
DRIFT: Final = 1e-3  # by which the clocks of page and server may differ in pace, with room
LONGEST_INTERVAL_S: Final = 0.2  # of a control interval: with a longer one hardly any command would be fresh enough


@dataclass(frozen=True)
class Fresh:
    """A command that counts.

    Attributes:
        along, across: Shares of the claw's greatest velocities.
        device: What was moved.
        sequence, input_ms, received_s: Of the message that first brought this command: its number, the page's clock
            [ms] and the server's [s] at its arrival.
    """

    along: float
    across: float
    device: str
    sequence: int
    input_ms: float
    received_s: float


class Newest:
    """Keeps the newest command that the driver's page has sent.

    Attributes:
        dropped: Commands that came out of order, or too late.
        renewed_s: Server's clock at the newest message [s]; minus infinity without one.
        shown_step: Newest control step that the page says it has drawn; -1: unknown.
    """

    def __init__(self) -> None:
        self.dropped = 0
        self.forget()

    def forget(self) -> None:
        """Another driver, or none: nothing that was sent counts any more, and numbers may start anew."""
        self._command: Fresh | None = None
        self._sequence = -1
        self.renewed_s = float("-inf")
        self._heard_s = 0.0
        self._fastest_s = float("inf")  # least time from the page's clock to the server's, whatever their zeros
        self.shown_step = -1

    def offer(self, message: Command, now_s: float) -> bool:
        """Take a message as the newest command; returns whether it is one.

        Its number must have risen, and it must not have been on its way for longer than a command counts: what a line
        held back is old when it comes. Only differences are known of the two clocks, so the way is measured against
        the fastest message.

        Args:
            message: The message.
            now_s: Server's clock at its arrival [s].
        """
        way_s = now_s - 1e-3 * message.stamp_ms
        waited_s = max(0.0, now_s - self._heard_s)
        self._fastest_s, self._heard_s = min(self._fastest_s + DRIFT * waited_s, way_s), now_s
        if message.sequence <= self._sequence or way_s > self._fastest_s + EXPIRY_S:
            self.dropped += 1
            return False
        self._sequence = message.sequence
        self.renewed_s = now_s
        self.shown_step = max(self.shown_step, message.shown)
        known = self._command
        if known is None or (known.along, known.across) != (message.along, message.across):
            self._command = Fresh(
                message.along, message.across, message.device, message.sequence, message.stamp_ms, now_s
            )
        return True

    def episode(self) -> None:
        """A new episode begins: steps are counted anew."""
        self.shown_step = -1

    def read(self, now_s: float, interval_s: float) -> Fresh | None:
        """The command for a control interval that starts now, if one is fresh enough; None: the claw is to stop."""
        age_s = now_s - self.renewed_s
        fresh = age_s <= EXPIRY_S and age_s + interval_s <= ZERO_WITHIN_S + 1e-9
        return self._command if fresh else None
