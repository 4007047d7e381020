"""The parser of the command line: argparse, which also says what was meant."""

import argparse
import re
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from meshfair.checks import did_you_mean

# argparse's words for what is wrong, and those that the rest of the command has.
_WORDS = {
    r"the following arguments are required: (.*)": r"\1 is missing",
    r": expected one argument": " needs a value",
}


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
        self._refuse_unknown_options(words)
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
        for pattern, words in _WORDS.items():
            message = re.sub(pattern, words, message)
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")

    def _refuse_unknown_options(self, words: Sequence[str]) -> None:
        """Before argparse, which would call something missing that such an option swallows."""
        known = list(self._option_string_actions)
        for word in words[: words.index("--") if "--" in words else None]:
            if not word.startswith("-"):
                if self._subparsers:
                    return  # what follows is the subcommand's
                continue
            if word == "-" or self._negative_number_matcher.match(word):
                continue
            name = word.partition("=")[0]
            if not any(option.startswith(name) for option in known):
                other = self.option_of.get(name.lstrip("-").replace("-", "_"))  # Python's name
                meant = f" (did you mean {other!r}?)" if other else did_you_mean(name, known)
                self.error(f"there is no option {name}{meant}")

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
