"""The parser of the command line: argparse, which also says what was meant."""

import argparse
import re
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from meshfair.checks import did_you_mean


class Parser(argparse.ArgumentParser):
    """A parser that refuses a wrong word in one line, with the closest right one.

    Parameters
    ----------
    **named
        As those of `argparse.ArgumentParser`.

    Attributes
    ----------
    list_of : str or None
        The argument that takes any number of words; words after an option belong to it too.
    """

    def __init__(self, **named: Any) -> None:
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, **named)
        self.list_of: str | None = None
        self.register("type", float, _number)
        self.register("type", int, _whole_number)
        # What begins like a negative number is a value, and no option: also -1e-3 and -inf.
        self._negative_number_matcher = re.compile(r"-(\d|\.\d|inf|nan)", re.IGNORECASE)

    @property
    def option_of(self) -> dict[str, str]:
        """The option that gives each argument, by the argument's name."""
        return {a.dest: a.option_strings[-1] for a in self._actions if a.option_strings}

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """As argparse does it; but what is unknown is refused here, by the subcommand itself."""
        words = sys.argv[1:] if args is None else list(args)
        # Before argparse, which would call something missing that an unknown option has swallowed.
        for word in words[: words.index("--") if "--" in words else None]:
            if self._subparsers and not word.startswith("-"):
                break
            name = word.partition("=")[0]
            if word.startswith("--") and not any(k.startswith(name) for k in self._known()):
                self.error(f"there is no option {name}{did_you_mean(name, self._known())}")
        found, unknown = super().parse_known_args(words, namespace)
        if unknown and self.list_of:
            getattr(found, self.list_of).extend(w for w in unknown if w[0] != "-" or w == "-")
            unknown = [word for word in unknown if word[0] == "-" and word != "-"]
        if unknown:
            self.error(f"{unknown[0]!r} is too much; give it as an option's value, or leave it out")
        return found, []

    def error(self, message: str) -> NoReturn:
        """Say what is wrong in one line, and end with exit code 2."""
        message = message.removeprefix("argument ")
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")

    def _known(self) -> list[str]:
        return [name for name in self._option_string_actions if name.startswith("--")]

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        choices = [str(choice) for choice in action.choices]
        listed = f"{', '.join(choices)}{did_you_mean(value, choices)}"
        if action.option_strings:
            raise argparse.ArgumentError(
                None, f"{action.option_strings[-1]} is {value!r}; give one of {listed}"
            )
        raise argparse.ArgumentError(None, f"there is no command {value!r}; there are {listed}")


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"give a number, not {text!r}") from None


def _whole_number(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"give a whole number, not {text!r}") from None
