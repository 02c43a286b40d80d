"""An XML file as a tree of elements, or one line that says why it is none."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

from oed.errors import RobotError

# Drake's and Pinocchio's reader (TinyXML-2) refuses more; a robot's file has about ten.
MOST_DEPTH = 200
ENDS_EARLY = 3  # expat's XML_ERROR_NO_ELEMENTS, "no element found"


@dataclass(frozen=True)
class XmlTree:
    """A parsed file.

    Attributes:
        root: Its outermost element; comments within are kept.
        prefixes: Of its namespaces, such as "drake", by address.
    """

    root: ElementTree.Element
    prefixes: dict[str, str]

    def text(self) -> str:
        """The tree as text, its namespaces under the prefixes that they had."""
        for address, prefix in self.prefixes.items():
            ElementTree.register_namespace(prefix, address)
        return ElementTree.tostring(self.root, encoding="unicode")


def parse_xml(content: bytes, where: str) -> XmlTree:
    """Parse a robot's file.

    Args:
        content: Of the file.
        where: Name of the file, for the message.

    Raises:
        RobotError: If it is empty, truncated, badly encoded, nested too deeply, or no XML.
    """
    if not content.strip():
        raise RobotError(f"{where}: this file is empty")
    target = _Builder(where)
    parser = ElementTree.XMLParser(target=target)  # noqa: S314  # the user's own robot file; expat bounds entities
    try:
        parser.feed(content)
        return XmlTree(parser.close(), target.prefixes)
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        reason = _reason(content, error)
        raise RobotError(f"{where}: cannot read this file as XML: {reason}") from error


class _Builder(ElementTree.TreeBuilder):
    """Builds the tree with its comments, refuses depth and notes prefixes."""

    def __init__(self, where: str) -> None:
        super().__init__(insert_comments=True)
        self._where = where
        self._depth = 0
        self.prefixes: dict[str, str] = {}

    def start(self, tag: str, attrs: dict[str, str], /) -> ElementTree.Element:
        self._depth += 1
        if self._depth > MOST_DEPTH:
            raise RobotError(
                f"{self._where}: elements are nested more than {MOST_DEPTH} deep; this is not a "
                "robot's file, or a damaged one"
            )
        return super().start(tag, attrs)

    def end(self, tag: str, /) -> ElementTree.Element:
        self._depth -= 1
        return super().end(tag)

    def start_ns(self, prefix: str | None, uri: str) -> None:
        # ElementTree keeps prefixes such as "ns1" for itself.
        if prefix and not (prefix.startswith("ns") and prefix[2:].isdigit()):
            self.prefixes[uri] = prefix


def _reason(content: bytes, error: Exception) -> str:
    if b"encoding=" not in content[:200] and not content.startswith((b"\xff\xfe", b"\xfe\xff")):
        try:
            content.decode("utf-8")
        except UnicodeDecodeError as fault:
            line = content[: fault.start].count(b"\n") + 1
            return f"byte 0x{content[fault.start]:02x} in line {line} is not UTF-8 text"
    if getattr(error, "code", None) == ENDS_EARLY or "unclosed" in str(error):
        return f"{error}: the file ends before its last element is closed; it is truncated"
    return str(error)
