"""Optional libraries: loaded when first used, named in one sentence where missing."""

from collections.abc import Iterator
from contextlib import contextmanager

EXTRAS = {
    "viewer": {"PIL", "matplotlib", "polyscope", "polyscope_bindings"},
    "notebooks": {"anywidget", "ipywidgets", "k3d", "traitlets"},
    "data": {"pooch"},
    "experiments": {"pandas", "tqdm"},
    "grading": {"jinja2", "jupytext", "nbformat"},
}
"""Modules that are imported for some uses alone, by the extra that installs them."""


class NotInstalledError(ModuleNotFoundError):
    """An optional library that is missing; the message says what to install."""


@contextmanager
def needed_for(purpose: str) -> Iterator[None]:
    """Import optional libraries in this block, or say in one sentence what to install.

    Parameters
    ----------
    purpose : str
        What needs them; the message's beginning.

    Raises
    ------
    NotInstalledError
        A library is missing, or does not load here.
    """
    try:
        yield
    except ImportError as error:
        library = (error.name or "a library").split(".")[0]
        if library == "meshfair":  # an error of ours, which no installation mends
            raise
        extra = next((name for name, modules in EXTRAS.items() if library in modules), "all")
        reason = str(error).splitlines()[0]
        raise NotInstalledError(
            f"{purpose} needs {library} ({reason}); run: {install(extra)}", name=error.name
        ) from None


def install(extra: str) -> str:
    """The command that installs the libraries of an extra."""
    return f'pip install "meshfair[{extra}]"'
