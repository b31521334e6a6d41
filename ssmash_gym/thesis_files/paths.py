"""Values of a nested document by dotted path."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final

MISSING: Final = object()
_STATION: Final = re.compile(r"(?<=stations\.)(?:auxiliary|right|left)(?=\.|$)")
_ENTRY: Final = re.compile(r"(?<=tires\.)\d+(?=\.|$)")


def get(document: Any, path: str) -> Any:
    """The value at a path, `MISSING` if there is none; of ``*`` the first entry."""
    found = document
    for key in path.split("."):
        if isinstance(found, Mapping):
            key = next(iter(found), "") if key == "*" else key
            found = found.get(key, MISSING)
        elif isinstance(found, Sequence) and not isinstance(found, str) and key.isdigit() and int(key) < len(found):
            found = found[int(key)]
        else:
            return MISSING
    return found


def put(document: Any, path: str, value: Any) -> None:
    """Set a value; mappings on the way are made, entries of lists must exist, ``*`` stands for all there are.

    Raises:
        KeyError: The path leads through something that is neither mapping nor list, or past the end of a list.
    """
    key, _, rest = path.partition(".")
    if key == "*":
        for each in list(document):
            put(document, f"{each}.{rest}" if rest else each, value)
        return
    if isinstance(document, list):
        if not key.isdigit() or int(key) >= len(document):
            raise KeyError(path)
        if rest:
            put(document[int(key)], rest, value)
        else:
            document[int(key)] = value
        return
    if not isinstance(document, dict):
        raise KeyError(path)
    if rest:
        put(document.setdefault(key, {}), rest, value)
    else:
        document[key] = value


def with_lists(tree: Any) -> Any:
    """The tree with each mapping from 0, 1, 2, ... made a list."""
    if not isinstance(tree, Mapping):
        return tree
    if tree and all(str(key).isdigit() for key in tree):
        return [with_lists(tree[key]) for key in sorted(tree, key=int)]
    return {key: with_lists(child) for key, child in tree.items()}


def nested(node: Any) -> bool:
    """Whether a node is a list of mappings; a list of numbers is one value."""
    return isinstance(node, list) and bool(node) and all(isinstance(entry, Mapping) for entry in node)


def leaves(node: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Every value with its path."""
    if isinstance(node, Mapping) and node:
        for key, child in node.items():
            yield from leaves(child, f"{path}.{key}" if path else str(key))
    elif nested(node):
        for k, child in enumerate(node):
            yield from leaves(child, f"{path}.{k}")
    else:
        yield path, node


def differences(one: Any, other: Any, path: str = "") -> Iterator[str]:
    """Paths of the smallest parts in which two documents differ; sections of different type differ as a whole."""
    if isinstance(one, Mapping) and isinstance(other, Mapping) and one.get("type") == other.get("type"):
        for key in [*one, *(key for key in other if key not in one)]:
            below = f"{path}.{key}" if path else str(key)
            yield from differences(one.get(key, MISSING), other.get(key, MISSING), below)
    elif nested(one) and nested(other) and len(one) == len(other):
        for k, (a, b) in enumerate(zip(one, other, strict=True)):
            yield from differences(a, b, f"{path}.{k}")
    elif one is not other and one != other:
        yield path


def pattern(path: str) -> str:
    """The path with ``*`` for station and tire."""
    return _ENTRY.sub("*", _STATION.sub("*", path))


def expand(document: Any, path: str) -> list[str]:
    """Every path of a document that a pattern stands for; a path without ``*`` stands for itself."""
    head, star, rest = path.partition("*")
    if not star:
        return [path]
    node = get(document, head.rstrip(".")) if head else document
    if isinstance(node, Mapping):
        keys = [str(key) for key in node]
    elif isinstance(node, list):
        keys = [str(k) for k in range(len(node))]
    else:
        return []
    return [full for key in keys for full in expand(document, f"{head}{key}{rest}")]


def gathered(values: Mapping[str, Any], document: Any) -> dict[str, Any]:
    """The same values by as few paths as possible: those of all stations, or of both tires, become one if alike."""
    return _merged(_merged(values, document, pattern), document, lambda path: _ENTRY.sub("*", path))


def _merged(values: Mapping[str, Any], document: Any, common: Callable[[str], str]) -> dict[str, Any]:
    groups: dict[str, list[str]] = {}
    for path in values:
        groups.setdefault(common(path), []).append(path)
    short: dict[str, Any] = {}
    for shared, paths in groups.items():
        first = values[paths[0]]
        if len(paths) > 1 and paths == expand(document, shared) and all(values[path] == first for path in paths):
            short[shared] = first
        else:
            short.update({path: values[path] for path in paths})
    return short
