"""What subcommands print: tables for people, JSON for programs, progress for waiting."""

import json
import math


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
