"""The characters of a text file, from whatever bytes a logger or a spreadsheet wrote for them."""

from __future__ import annotations

from oed.errors import DataSetError

UTF_8, UTF_16, WINDOWS = "UTF-8", "UTF-16", "Windows-1252"
UTF_16_MARKS = (b"\xff\xfe", b"\xfe\xff")  # its byte-order marks


def decode(content: bytes, file: str) -> tuple[str, str]:
    """Text without a byte-order mark, and the name of its encoding.

    What is no UTF-8 is Windows-1252, in which spreadsheets of western Europe save a CSV: it differs
    in letters with accents and in signs such as those of degrees and micro, never in a number.

    Raises:
        DataSetError: If it is no text in any of them.
    """
    if content.startswith(UTF_16_MARKS):
        try:
            return _without_zero(content.decode("utf-16"), file), UTF_16
        except UnicodeError as error:
            message = f"is damaged UTF-16 text ({error}); save the file as UTF-8"
            raise DataSetError(message, file=file) from error
    try:
        return _without_zero(content.decode("utf-8-sig"), file), UTF_8
    except UnicodeDecodeError:
        pass
    try:
        return _without_zero(content.decode("cp1252"), file), WINDOWS
    except UnicodeDecodeError as error:
        row = content[: error.start].count(b"\n") + 1
        message = (
            f"byte 0x{content[error.start]:02x} is neither {UTF_8} nor {WINDOWS} text; "
            f"save the file as {UTF_8}"
        )
        raise DataSetError(message, file=file, row=row) from error


def _without_zero(text: str, file: str) -> str:
    before, zero, _ = text.partition("\0")
    if zero:
        row = before.count("\n") + 1
        raise DataSetError("holds a zero byte; it is not a text file", file=file, row=row)
    return text
