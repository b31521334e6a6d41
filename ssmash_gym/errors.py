"""What the package raises when a person's input is at fault."""

from __future__ import annotations

from importlib import import_module


class ConfigurationError(ValueError):
    """A configuration is refused; the message is one sentence with the file, the key, the value and what is allowed."""


class ConfigurationWarning(UserWarning):
    """A configuration is accepted, but something in it is probably not meant."""


class SolverError(RuntimeError):
    """A numerical integration gave up; the message is one sentence with the method, the time and the reason."""


def refusal(source: str, path: str, value: object, allowed: str) -> ConfigurationError:
    """Make the error for one value.

    Args:
        source: File or object that the value comes from.
        path: Dotted path of the key.
        value: The value that was given.
        allowed: What is allowed, as the rest of a sentence.
    """
    return ConfigurationError(f"{source}: {path} = {shown(value)} is refused: {allowed}.")


def shown(value: object, limit: int = 80) -> str:
    """Write a value as it goes into a message: short, and with strings in quotes."""
    text = repr(value)
    return text if len(text) <= limit else text[: limit - 3] + "..."


def require(library: str, sentence: str) -> None:
    """Check that an optional library is there.

    Raises:
        ImportError: It is missing; `sentence` names the extra that brings it.
    """
    try:
        import_module(library)
    except ImportError:
        raise ImportError(sentence) from None
