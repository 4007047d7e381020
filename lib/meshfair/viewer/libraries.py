"""Optional libraries: loaded when first used, named in one line where missing."""

from importlib import import_module

EXTRA = 'pip install "meshfair[notebooks]"'


def load(name, purpose):
    """Import an optional library, or say in one line what to install.

    Parameters
    ----------
    name : str
        What to import.
    purpose : str
        What needs it; the message's beginning.

    Returns
    -------
    module

    Raises
    ------
    ImportError
        The library is missing, or does not load here.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise ImportError(f"{purpose} needs {name} ({error}); run: {EXTRA}") from None
