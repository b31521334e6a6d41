"""Where the configurations and the agents lie: in the checkout, or inside the installed package."""

from __future__ import annotations

from pathlib import Path
from typing import Final

_PACKAGE: Final = Path(__file__).resolve().parent


def asset_path(*parts: str) -> Path:
    """Find a file or folder that ships with the package.

    Args:
        parts: Path from the root of the checkout, e.g. ``("configs", "helicopters")``.

    Returns:
        The path inside the installed package (``_assets``) if it is there, else the one in the checkout.

    Raises:
        FileNotFoundError: Neither exists.
    """
    for root in (_PACKAGE / "_assets", _PACKAGE.parent):
        path = root.joinpath(*parts)
        if path.exists():
            return path
    raise FileNotFoundError(f"{'/'.join(parts)} is neither in {_PACKAGE / '_assets'} nor in {_PACKAGE.parent}")
