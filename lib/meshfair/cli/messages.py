"""What a subcommand says on standard error: warnings and errors, each in one line."""

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from meshfair.checks import NotInstalledError
from meshfair.cli.words import in_words_of_the_command

TRACEBACK_VARIABLE = "MESHFAIR_TRACEBACK"


class Messages:
    """The messages of one run of a subcommand.

    Parameters
    ----------
    name : str
        The command with its subcommand, with which each line begins.
    option_of : dict of str
        The option for each argument's name, in place of which messages name it.
    """

    def __init__(self, name: str, option_of: dict[str, str]) -> None:
        self.name, self.option_of = name, option_of

    def say(self, message: str) -> None:
        """Print one line on standard error, whatever the message holds."""
        print(f"{self.name}: {' '.join(message.split())}", file=sys.stderr)

    @contextmanager
    def warnings(self, about: str = "") -> Iterator[None]:
        """Show the package's warnings, each once, and whom they are about."""
        with warnings.catch_warnings():
            warnings.simplefilter("default", UserWarning)
            warnings.simplefilter("ignore", RuntimeWarning)  # NumPy's; `files.write` looks itself
            warnings.showwarning = lambda message, *_, **__: self.say(
                f"warning: {self._named(self.in_words(str(message)), about)}"
            )
            yield

    def explained(self, error: Exception, about: str = "") -> tuple[str, int]:
        """What went wrong, in one line, and the exit code for it.

        Parameters
        ----------
        error : Exception
            Raised anew where the environment variable asks for the traceback.
        about : str
            Which of several files it is about.

        Returns
        -------
        (str, int)
        """
        if os.environ.get(TRACEBACK_VARIABLE):
            raise error
        if isinstance(error, MemoryError):
            return self._named("not enough memory; use a smaller mesh or free some", about), 1
        if isinstance(error, NotInstalledError):
            return str(error), 1
        if isinstance(error, ModuleNotFoundError) and not _own(error):
            return f"this needs {error.name}, which is not installed; see meshfair doctor", 1
        if isinstance(error, (ValueError, ArithmeticError, OSError)):  # the package's own are these
            return self._named(self.in_words(str(error)), about), 1
        return (
            f"{type(error).__name__}: {error}. This is an error of meshfair; please report it "
            f"with what {TRACEBACK_VARIABLE}=1 shows"
        ), 70

    def in_words(self, message: str) -> str:
        """A message of the package in the words of the command."""
        return in_words_of_the_command(message, self.option_of)

    @staticmethod
    def _named(message: str, about: str) -> str:
        return message if not about or message.startswith(about) else f"{about}: {message}"


def _own(error: ModuleNotFoundError) -> bool:
    return (error.name or "").startswith("meshfair.")
