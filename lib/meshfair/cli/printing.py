"""What subcommands print: tables for people, JSON for programs, progress for waiting."""

import json
import math
from contextlib import contextmanager


def print_json(facts):
    """Print one JSON object; numbers that JSON does not have (NaN, infinite) become null."""
    print(json.dumps(_plain(facts), indent=2, allow_nan=False))


def _plain(value):
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


def print_table(rows):
    """Print names and values in two columns; numbers with six digits."""
    rows = [
        (name, f"{value:.6g}" if isinstance(value, float) else str(value)) for name, value in rows
    ]
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        print(f"{name:<{width}}  {value}")


@contextmanager
def progress():
    """Show on standard error, if that is a terminal, how far long work has come.

    Without tqdm, an optional extra, nothing is shown.

    Yields
    ------
    function of a float
        To call with the part of the work that is done, 0 to 1.
    """
    try:
        from tqdm import tqdm
    except ImportError:
        yield lambda part: None
        return
    form = "{percentage:3.0f}% |{bar}| {elapsed} < {remaining}"
    with tqdm(total=1.0, bar_format=form, leave=False, disable=None) as bar:

        def advance(part):
            bar.update(part - bar.n)

        yield advance
