"""Real-time monitoring of a flight deck: how much margin there is, when it will be quiet, what starting now risks."""

from __future__ import annotations

from ssmash_gym.monitor.settings import Settings
from ssmash_gym.monitor.watch import Answer, Monitor

__all__ = ["Answer", "Monitor", "Settings"]
