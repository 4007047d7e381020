"""What subcommands print: tables for people, JSON for programs, progress for waiting."""

import json
import math
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import zip_longest
from typing import Any, TextIO

from meshfair.cli.files import STANDARD


def beside(out: object) -> TextIO:
    """Where to print: standard output, unless it is what the mesh is written to."""
    return sys.stderr if out == STANDARD else sys.stdout


def print_json(facts: Mapping[str, Any], to: TextIO | None = None) -> None:
    """Print one JSON object; of numbers that JSON has not, NaN is null, infinite ones are texts."""
    print(json.dumps(_plain(facts), indent=2, allow_nan=False), file=to)


def _plain(value: Any) -> Any:
    """The same in types that JSON has."""
    if isinstance(value, dict):
        return {str(name): _plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):  # NumPy's arrays and numbers
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value if isinstance(value, (str, int, float, bool, type(None))) else str(value)


def print_table(
    rows: Iterable[Sequence[Any]], to: TextIO | None = None, *, clip_first: bool = False
) -> None:
    """Print rows in columns, but for the last cell as wide as they need; numbers with six digits.

    Parameters
    ----------
    rows : iterable of sequences
        Of any lengths; the last cell of a row is in nobody's way.
    to : file, optional
        Standard output by default.
    clip_first : bool
        Shorten the first column, of names, where a terminal is too narrow for the rows.
    """
    texts = [[shortened(cell) for cell in row] for row in rows]
    if clip_first and (to or sys.stdout).isatty():
        others = zip_longest(*(row[1:] for row in texts), fillvalue="")
        room = width() - sum(2 + max(map(len, column)) for column in others)
        texts = [[clipped(row[0], room), *row[1:]] for row in texts]
    widths: dict[int, int] = {}
    for row in texts:
        for k, cell in enumerate(row[:-1]):
            widths[k] = max(widths.get(k, 0), len(cell))
    for row in texts:
        cells = [f"{cell:<{widths[k]}}" for k, cell in enumerate(row[:-1])]
        print("  ".join([*cells, *row[-1:]]), file=to)


def clipped(name: str, room: int) -> str:
    """A name in so many characters, 16 at least: beginning and end, and dots between."""
    over = len(name) - max(room, 16)
    if over <= 0:
        return name
    begin = (len(name) - over - 3) // 2
    return f"{name[:begin]}...{name[begin + over + 3 :]}"


def width() -> int:
    """How long lines may be: as wide as the terminal is, up to what is read well."""
    return min(88, shutil.get_terminal_size((80, 1)).columns)


def wrapped(text: str, indent: str = "") -> str:
    """A text in lines of `width`; names and numbers stay whole."""
    return textwrap.fill(
        text, width(), subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def shortened(value: Any, digits: int = 6) -> str:
    """A value as text; a number with so many digits."""
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


@contextmanager
def progress(label: str = "") -> Iterator[Callable[[float], None]]:
    """Show on standard error, if that is a terminal and tqdm is there, how far the work is.

    Parameters
    ----------
    label : str
        What is worked on, where there are several.

    Yields
    ------
    function of a float
        To call with the part of the work that is done, 0 to 1.
    """
    if not sys.stderr.isatty():  # and tqdm, which takes an eighth of a second, is not loaded
        yield lambda part: None
        return
    try:
        from tqdm import tqdm
    except ModuleNotFoundError:
        yield lambda part: None
        return
    form = "{desc}{percentage:3.0f}% |{bar}| {elapsed} < {remaining}"
    with tqdm(total=1.0, desc=label, bar_format=form, leave=False) as bar:

        def advance(part: float) -> None:
            bar.update(part - bar.n)

        yield advance
