"""A reader of the HTML that this package writes."""

from __future__ import annotations

from html.parser import HTMLParser

VOID = ("meta", "img", "br", "path", "use", "rect", "stop")  # tags that have no end


class HtmlReader(HTMLParser):
    """Checks that tags are closed in order; collects attributes and texts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.texts: list[str] = []
        self.prepare()
        self.feed(text)
        self.close()
        assert not self.open

    def prepare(self) -> None:
        """What a subclass needs before anything is read."""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)
