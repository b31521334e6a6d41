"""Reading and writing a description: plain YAML in which a number can carry its mark.

A number, vector or tensor is written either bare or as a leaf ``{value: 9937.24, origin: derived, note: "..."}``.
The mark stands where the number stands. Reading splits a document into plain values and marks; writing joins them
again, so that nothing is lost on the way from file to object to file.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final, Literal, get_args

import numpy as np
import yaml
from pydantic import BaseModel, ConfigDict

from ssmash_gym.errors import ConfigurationError, refusal

Origin = Literal["source", "derived", "fitted", "assumed"]
ORIGINS: Final = get_args(Origin)
_LEAF_KEYS: Final = frozenset({"value", "origin", "note"})


class Mark(BaseModel):
    """Where one value comes from.

    ``source``: a published figure; ``derived``: worked out from such figures; ``fitted``: identified so that
    published results come out; ``assumed``: chosen without evidence.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    path: str
    origin: Origin
    note: str = ""


class _Loader(yaml.SafeLoader):
    """Safe YAML that also reads ``1e6`` as a number and refuses a key written twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [key for key, _ in node.value if key.tag != "tag:yaml.org,2002:merge"]
        if not all(isinstance(key, yaml.ScalarNode) for key in keys):
            raise yaml.constructor.ConstructorError(None, None, "a key must be a plain word", node.start_mark)
        written = [key.value for key in keys]
        if len(set(written)) < len(written):
            twice = next(key for key in written if written.count(key) > 1)
            raise yaml.constructor.ConstructorError(None, None, f"the key {twice} is written twice", node.start_mark)
        return super().construct_mapping(node, deep=deep)


class _Dumper(yaml.SafeDumper):
    """Writes a leaf, and a sequence without mappings in it, on one line."""

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_mapping(self, tag: str, mapping: Any, flow_style: bool | None = None) -> yaml.MappingNode:
        return super().represent_mapping(tag, mapping, flow_style=is_leaf(mapping))

    def represent_sequence(self, tag: str, sequence: Any, flow_style: bool | None = None) -> yaml.SequenceNode:
        return super().represent_sequence(tag, sequence, flow_style=not any(isinstance(s, Mapping) for s in sequence))


for _one in (_Loader, _Dumper):  # 1e5 is a number to both: the text "1e5" is then written with its quotes
    _one.add_implicit_resolver(
        "tag:yaml.org,2002:float",
        re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)[eE][-+]?\d+$"),
        list("-+.0123456789"),
    )


def is_leaf(node: Any) -> bool:
    """Whether a node of a document is a value with its mark."""
    return isinstance(node, Mapping) and bool({"value", "origin"} & set(node))


def read_yaml(text: str, source: str) -> dict[str, Any]:
    """Parse a document.

    Args:
        text: YAML (or JSON) text.
        source: Its name in messages.

    Raises:
        ConfigurationError: It is no YAML, a key is written twice, or it is not a mapping.
    """
    try:
        document = yaml.load(text, Loader=_Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f", line {mark.line + 1}" if mark is not None else ""
        problem = " ".join(str(getattr(error, "problem", None) or error).split())
        raise ConfigurationError(f"{source}{line}: this is not valid YAML: {problem}.") from None
    if not isinstance(document, dict):
        raise ConfigurationError(f"{source}: the file must hold a mapping of keys to values.")
    return document


def read_file(path: Path) -> dict[str, Any]:
    """Read a YAML (or JSON) file.

    Raises:
        ConfigurationError: It cannot be read, is no text in UTF-8, is no YAML, or holds no mapping.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ConfigurationError(
            f"{path}: byte {error.start + 1} is not valid UTF-8; save the file as UTF-8."
        ) from None
    except OSError as error:
        raise ConfigurationError(f"{path}: the file cannot be read ({error.strerror or error}).") from None
    return read_yaml(text, str(path))


def read_record(path: Path) -> dict[str, Any]:
    """A JSON record that this package has written; empty where there is none.

    Raises:
        ConfigurationError: It cannot be read.
    """
    if not path.is_file():
        return {}
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, TypeError, OSError) as error:
        raise ConfigurationError(f"{path}: this record cannot be read ({error}).") from None


def plain_copy(value: Any) -> Any:
    """A copy of a node that shares nothing with it: NumPy numbers and tuples become what a document holds."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: plain_copy(child) for key, child in value.items()}
    if isinstance(value, list | tuple):
        return [plain_copy(child) for child in value]
    return value


def write_yaml(document: Mapping[str, Any]) -> str:
    """Write a document as YAML text that `read_yaml` reads back without loss."""
    return yaml.dump(dict(document), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=120)


def split(node: Any, source: str, path: str = "") -> tuple[Any, list[dict[str, str]]]:
    """Take the marks out of a document.

    Args:
        node: The document, or a node of it.
        source: Its name in messages.
        path: Dotted path of the node.

    Returns:
        The plain node, and the marks as mappings with ``path``, ``origin`` and ``note``.

    Raises:
        ConfigurationError: A leaf is not well formed.
    """
    if is_leaf(node):
        return _split_leaf(node, source, path)
    marks: list[dict[str, str]] = []
    if isinstance(node, Mapping):
        plain: dict[Any, Any] = {}
        for key, child in node.items():
            plain[key], found = split(child, source, f"{path}.{key}" if path else str(key))
            marks += found
        return plain, marks
    if isinstance(node, Sequence) and not isinstance(node, str):
        items = []
        for k, child in enumerate(node):
            item, found = split(child, source, f"{path}.{k}")
            items.append(item)
            marks += found
        return items, marks
    return node, marks


def _split_leaf(node: Mapping[str, Any], source: str, path: str) -> tuple[Any, list[dict[str, str]]]:
    shape = f"a marked value is written {{value: ..., origin: one of {', '.join(ORIGINS)}, note: optional text}}"
    if not set(node) <= _LEAF_KEYS or not {"value", "origin"} <= set(node):
        raise refusal(source, path, dict(node), shape)
    if node["origin"] not in ORIGINS:
        raise refusal(source, f"{path}.origin", node["origin"], f"it must be one of {', '.join(ORIGINS)}")
    plain, nested = split(node["value"], source, path)
    if nested or isinstance(plain, Mapping):
        raise refusal(
            source, path, node["value"], f"a value carries one mark only, and no mapping carries one; {shape}"
        )
    return plain, [{"path": path, "origin": node["origin"], "note": str(node.get("note", ""))}]


def join(node: Any, marks: Mapping[str, Any], path: str = "") -> Any:
    """Put the marks back: the inverse of `split`.

    Args:
        node: Plain node.
        marks: Objects with ``origin`` and ``note`` by dotted path.
        path: Dotted path of the node.
    """
    if path in marks:
        mark = marks[path]
        leaf = {"value": node, "origin": mark.origin}
        return {**leaf, "note": mark.note} if mark.note else leaf
    if isinstance(node, Mapping):
        return {key: join(child, marks, f"{path}.{key}" if path else str(key)) for key, child in node.items()}
    if isinstance(node, Sequence) and not isinstance(node, str):
        return [join(child, marks, f"{path}.{k}") for k, child in enumerate(node)]
    return node


def listed(words: str) -> list[str]:
    """Names with commas between them, in order; empty ones are left out."""
    return [name.strip() for name in words.split(",") if name.strip()]
