"""Text files as arrays: their lines, words and numbers, found by NumPy and not by a loop."""

import codecs
import copy
import re
import warnings
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NoReturn, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import Booleans, Floats, Integers
from meshfair.io.errors import DAMAGED, file_error, quoted

# At the start of a line, or after a blank: in 1.#QNAN, as C prints NaN on Windows, is none.
COMMENT = re.compile(rb"#(?<!\S#)[^\n]*")


def normalised_text(data: bytes, *, comments: bool) -> bytes:
    """Text with line feeds around every line, without byte-order mark and comments.

    No line is joined or dropped, so that what is found in the text can be named by
    its line in the file; and byte k of the file is byte k + 1 of the text, so that
    it can be found there. The last line has two line feeds: one is left where the
    other is joined to the next line.

    Parameters
    ----------
    data : bytes
    comments : bool
        Whether ``#`` begins a comment in this format; it is replaced by blanks.
    """
    if data.startswith(codecs.BOM_UTF8):
        data = blanked(codecs.BOM_UTF8) + data[len(codecs.BOM_UTF8) :]
    data = data.replace(b"\r\n", b"\n ").replace(b"\r", b"\n")
    if comments:
        data = COMMENT.sub(lambda comment: b" " * len(comment[0]), data)
    return b"\n%b\n\n" % data


def blanked(text: bytes) -> bytes:
    """As many blanks, in the same lines."""
    return re.sub(rb"[^\n]", b" ", text)


def words_of(text: bytes) -> tuple[Integers, Integers]:
    """Where each word of a normalised text begins in its file, and how long it is."""
    blank = is_blank(np.frombuffer(text, np.uint8))
    edges = np.flatnonzero(blank[1:] != blank[:-1])  # a text begins and ends with a blank
    return edges[::2], edges[1::2] - edges[::2]


def line_at(text: bytes, position: int) -> str:
    """Where in the file a position of its normalised text is."""
    return f"line {text.count(10, 0, position)}"


def parse_numbers(text: bytes, dtype: type, size: int) -> NDArray[Any] | None:
    """The numbers of a text, or None if it is not exactly ``size`` of them between blanks."""
    if not size:
        return np.empty(0, dtype)  # np.fromstring finds a number where there is none
    if text.rstrip()[-1:] in (b"+", b"-"):  # it takes a last sign alone for an integer zero
        return None
    with warnings.catch_warnings():
        # NumPy before 2.3 only warns of a word that is no number.
        warnings.simplefilter("error", DeprecationWarning)
        try:
            numbers: NDArray[Any] = np.fromstring(text, dtype, sep=" ")
        except (ValueError, DeprecationWarning):
            return None
    # It asks the locale what is blank, so the number of words may be another.
    return numbers if len(numbers) == size else None


def is_blank(codes: NDArray[np.uint8]) -> Booleans:
    """Which bytes are white space: 32, and 9 to 13 (smaller ones wrap around)."""
    return (codes == 32) | (codes - np.uint8(9) < 5)


class Lines:
    """The lines of a normalised text that are not blank.

    Parameters
    ----------
    text : bytes
        What `normalised_text` returns, or the same with some bytes replaced.
    original : bytes, optional
        What `normalised_text` returned, where lines were joined since.

    Attributes
    ----------
    codes : ndarray of uint8
        The bytes of the lines, one line after another.
    begin : ndarray of int64, shape (k,)
        Where in ``codes`` the first word of each line is.
    words : ndarray of int64, shape (k,)
        The number of words of each line.
    """

    def __init__(self, text: bytes, original: bytes | None = None) -> None:
        codes = np.frombuffer(text, np.uint8)
        blank = is_blank(codes)
        word = np.flatnonzero(blank[:-1] & ~blank[1:]) + 1
        first = np.searchsorted(word, np.flatnonzero(codes == 10))
        words = np.diff(first)
        self._text, self._position = original or text, word[first[:-1][words > 0]]
        skipped = self._position[0] if len(word) else len(codes)
        self.codes, self.begin = codes[skipped:], self._position - skipped
        self.words = words[words > 0]

    def __len__(self) -> int:
        return len(self.begin)

    def __getitem__(self, which: slice | Booleans) -> Self:
        """The lines that a slice or a mask chooses."""
        chosen = np.zeros(len(self), bool)
        chosen[which] = True
        length = np.diff(self.begin, append=len(self.codes))
        lines = copy.copy(self)
        lines.codes = self.codes[np.repeat(chosen, length)]
        lines.begin = np.cumsum(length[chosen]) - length[chosen]
        lines.words, lines._position = self.words[chosen], self._position[chosen]
        return lines

    def place(self, i: int) -> str:
        """Where line ``i`` is in the file."""
        return line_at(self._text, self._position[i])

    def require(
        self,
        fits: Booleans,
        values: NDArray[Any],
        found: str,
        expected: str,
        advice: str = DAMAGED,
    ) -> None:
        """Raise an error at the first line that does not fit; its value begins what is found."""
        if not np.all(fits):
            i = int(np.argmin(fits))
            value = quoted(values[i]) if values.dtype.kind == "S" else values[i]
            raise file_error(self.place(i), f"{value} {found}", expected, advice)

    def split(self) -> list[list[bytes]]:
        """The words of each line."""
        lines = self.codes.tobytes().split(b"\n")
        return [words for line in lines if (words := line.split())]

    def as_rows(self, tables: Sequence[tuple[int, Sequence[bool]]]) -> Self:
        """The same words with one row a line, if the file breaks its lines elsewhere.

        Parameters
        ----------
        tables : list of (int, list of bool)
            For each table that follows its number of rows, and for each of its
            columns whether it is a list: its length and as many values.

        Returns
        -------
        Lines
            As many as there are rows; or those there are, if no rows fit.
        """
        if len(self) == sum(rows for rows, _ in tables):
            return self
        sizes = _row_sizes(self.numbers(), tables)
        if sizes is None:
            return self
        lines = copy.copy(self)
        lines.words = np.array(sizes)
        blank = is_blank(self.codes)
        word = np.flatnonzero(~blank & np.append(True, blank[:-1]))
        lines.begin = word[lines.starts()]
        line = np.searchsorted(self.begin, lines.begin, side="right") - 1
        lines._position = self._position[line]
        return lines

    def first_words(self, length: int) -> NDArray[np.bytes_]:
        """The first word of each line, cut to a number of letters."""
        last = len(self.codes) - 1
        columns = [self.codes[np.minimum(self.begin + k, last)] for k in range(length)]
        letters = np.column_stack(columns)
        letters[np.logical_or.accumulate(is_blank(letters), axis=1)] = 0
        return letters.view(f"S{length}").ravel()

    def without_letter(self) -> Self:
        """The same lines without the word of one letter that each starts with."""
        lines = copy.copy(self)
        lines.codes, lines.words = self.codes.copy(), self.words - 1
        lines.codes[lines.begin] = 32
        return lines

    def without(self, pattern: re.Pattern[bytes]) -> "Lines":
        """The same lines without what a pattern matches, which is never a whole word."""
        lines = Lines(b"\n" + pattern.sub(b"", self.codes.tobytes()))
        lines._text, lines._position = self._text, self._position
        return lines

    def starts(self) -> Integers:
        """Where among all the numbers those of each line start."""
        return np.cumsum(self.words) - self.words

    def numbers(self, dtype: type = np.float64) -> NDArray[Any]:
        """All the words as numbers, in one array; any other word is an error."""
        numbers = self._parse(dtype)
        if numbers is None:
            self._blame(dtype)
        return numbers

    def _parse(self, dtype: type) -> NDArray[Any] | None:
        return parse_numbers(self.codes.tobytes(), dtype, self.words.sum())

    def _blame(self, dtype: type) -> NoReturn:
        """Raise the error of the first word that is no number, found by halving the lines."""
        lines = self
        while len(lines) > 1:
            half = len(lines) // 2
            sound = lines[:half]._parse(dtype) is not None
            lines = lines[half:] if sound else lines[:half]
        words = lines.codes.tobytes().split()
        word = next(word for word in words if parse_numbers(word, dtype, 1) is None)
        wanted = "an integer" if dtype == np.int64 else "a number"
        raise file_error(lines.place(0), f"found {quoted(word)}", f"{wanted} was expected")


def _row_sizes(numbers: Floats, tables: Sequence[tuple[int, Sequence[bool]]]) -> list[int] | None:
    """How many numbers each row has, or None if they are too few or too many."""
    sizes: list[int] = []
    at = 0
    for rows, columns in tables:
        for _ in range(rows):
            start = at
            for is_list in columns:
                length = numbers[at] if is_list and at < len(numbers) else 0
                if not 0 <= length < len(numbers) - at:
                    return None
                at += 1 + int(length)
            sizes.append(at - start)
    return sizes if at == len(numbers) else None


def encode_rows(pattern: str, values: NDArray[Any]) -> bytes:
    """One line for each row of an array; %r writes a number so that it reads back the same."""
    return (pattern * len(values) % tuple(values.ravel().tolist())).encode()


Ragged: TypeAlias = tuple[NDArray[Any], Integers]
"""Some values of each row, one row after another; and how many each row has."""


def encode_ragged(*columns: Ragged) -> bytes:
    """One line for each row, of the values of all columns; see `encode_rows`."""
    return b"".join(
        b" ".join(parts) + b"\n" for parts in zip(*map(_ragged_rows, columns), strict=True)
    )


def _ragged_rows(column: Ragged) -> list[bytes]:
    values, counts = column
    words = values.tolist()
    if values.dtype.kind != "S":
        words = ("%r " * len(words) % tuple(words)).encode().split()
    ends = np.cumsum(counts).tolist()
    return [b" ".join(words[a:b]) for a, b in pairwise([0, *ends])]
