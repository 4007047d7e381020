"""Submissions that look alike, for the teacher to look at: no proof of anything.

Files are compared by their tokens, without comments, docstrings and the names
that students choose, in passages of a few tokens (shingles). What was handed
out, what the instructor's own solution has, and what many of the class have
does not count.
"""

import io
import keyword
import tokenize
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations

LENGTH = 12  # tokens of a passage: about a line of code
# A passage that more of the class have is the usual way to do it.
COMMON = 0.2
COMMON_AT_LEAST = 4
# A pair is named from this share of the passages of the one that has fewer, and this many.
THRESHOLD = 0.6
LEAST_SHARED = 60
MOST_TOKENS = 20_000  # of one file; the assignments take some hundred
KEPT = frozenset(keyword.kwlist)
Passages = dict[tuple[str, ...], list[int]]


@dataclass(frozen=True)
class Pair:
    """Two submissions that look alike."""

    students: tuple[str, str]
    share: float
    """Of the passages of the one that has fewer."""
    lines: tuple[str, str]
    """Where the common passages stand in each, such as ``12-30, 41``."""


def similar(submissions: Mapping[str, bytes], known: Mapping[str, bytes]) -> list[Pair]:
    """The pairs of submissions that look alike, most alike first.

    Parameters
    ----------
    submissions : dict of str to bytes
        Files by student.
    known : dict of str to bytes
        Code that anybody may have: what was handed out, the solution.

    Returns
    -------
    list of Pair
    """
    passages = {student: _passages(source) for student, source in submissions.items()}
    counts = Counter(passage for of_one in passages.values() for passage in of_one)
    usual = max(COMMON_AT_LEAST, COMMON * len(submissions))
    public = {passage for source in known.values() for passage in _passages(source)}
    public |= {passage for passage, count in counts.items() if count > usual}
    own = {student: of_one.keys() - public for student, of_one in passages.items()}
    pairs = []
    for one, other in combinations(sorted(own), 2):
        shared = own[one] & own[other]
        share = len(shared) / max(1, min(len(own[one]), len(own[other])))
        if share >= THRESHOLD and len(shared) >= LEAST_SHARED:
            lines = tuple(_lines(passages[student], shared) for student in (one, other))
            pairs.append(Pair((one, other), share, (lines[0], lines[1])))
    return sorted(pairs, key=lambda pair: -pair.share)


def _passages(source: bytes) -> Passages:
    """All passages of a file, each with the lines on which it stands."""
    tokens = list(_tokens(source))[:MOST_TOKENS]
    found: Passages = {}
    for start in range(len(tokens) - LENGTH + 1):
        piece = tokens[start : start + LENGTH]
        lines = found.setdefault(tuple(text for text, _ in piece), [])
        lines += [line for _, line in piece]
    return found


def _tokens(source: bytes) -> Iterator[tuple[str, int]]:
    """Tokens and their lines; names of the student's own are all one."""
    skipped = {tokenize.COMMENT, tokenize.NL, tokenize.ENCODING, tokenize.ENDMARKER}
    skipped |= {tokenize.INDENT, tokenize.DEDENT}
    before = "\n"
    try:
        for token in tokenize.tokenize(io.BytesIO(source).readline):
            if token.type in skipped:
                continue
            text = token.string
            if token.type == tokenize.NEWLINE:
                text = "\n"
            elif token.type == tokenize.STRING:
                if before == "\n":  # a docstring, or text that does nothing
                    continue
                text = "text"
            elif token.type == tokenize.NAME and text not in KEPT and before != ".":
                text = "name"
            before = text
            yield text, token.start[0]
    except (tokenize.TokenError, SyntaxError, UnicodeError):
        return  # what could be read is compared


def _lines(passages: Passages, shared: set[tuple[str, ...]]) -> str:
    """The lines of some passages, as ranges."""
    lines = sorted({line for passage in shared for line in passages[passage]})
    ranges: list[list[int]] = []
    for line in lines:
        if ranges and line <= ranges[-1][1] + 2:  # a comment or an empty line between
            ranges[-1][1] = line
        else:
            ranges.append([line, line])
    return ", ".join(f"{a}" if a == b else f"{a}-{b}" for a, b in ranges)
