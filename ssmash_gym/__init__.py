"""Shipboard securing and manoeuvring of helicopters: dynamics, environment, training."""

from __future__ import annotations

__version__ = "0.1.0"
