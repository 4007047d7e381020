"""What subcommands print: tables for people, JSON for programs, progress for waiting."""

import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any


def print_json(facts: Mapping[str, Any]) -> None:
    """Print one JSON object; numbers that JSON does not have (NaN, infinite) become null."""
    print(json.dumps(_plain(facts), indent=2, allow_nan=False))


def _plain(value: Any) -> Any:
    """The same in types that JSON has."""
    if isinstance(value, dict):
        return {str(name): _plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):  # NumPy's arrays and numbers
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if isinstance(value, (str, int, float, bool, type(None))) else str(value)


def print_table(rows: Iterable[tuple[str, Any]]) -> None:
    """Print names and values in two columns; numbers with six digits."""
    texts = [
        (name, f"{value:.6g}" if isinstance(value, float) else str(value)) for name, value in rows
    ]
    width = max(len(name) for name, _ in texts)
    for name, value in texts:
        print(f"{name:<{width}}  {value}")


@contextmanager
def progress() -> Iterator[Callable[[float], None]]:
    """Show on standard error, if that is a terminal and tqdm is there, how far the work is.

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
    form = "{percentage:3.0f}% |{bar}| {elapsed} < {remaining}"
    with tqdm(total=1.0, bar_format=form, leave=False) as bar:

        def advance(part: float) -> None:
            bar.update(part - bar.n)

        yield advance
