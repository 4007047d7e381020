"""A method's parameters on the command line: their list, and their values from words."""

from __future__ import annotations

import argparse
import re
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from meshfair.checks import MeshError, did_you_mean

# That of `meshfair.denoise`, which is not loaded for --help.
DEFAULT_METHOD = "auto"
AUTO = "one of these with its parameters, chosen from the mesh alone"


def assignment(text: str) -> tuple[str, str]:
    """A name and a value from NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not (name.isidentifier() and equals and value):
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form NAME=VALUE")
    return name, value


class ListMethods(argparse.Action):
    """Print every method, what it does, and its parameters' defaults; and stop."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        """Do what argparse calls an action for."""
        from meshfair import denoising
        from meshfair.cli.printing import wrapped

        print(wrapped(f"{DEFAULT_METHOD} (the default): {AUTO}", "    "))
        for method in denoising.methods():
            print(wrapped(f"{method}: {summary(method)}", "    "))
            print(wrapped("    " + " ".join(f"{n}={v}" for n, v in known(method).items()), "    "))
        parser.exit()


def summary(method: str) -> str:
    """What a method does, in a line: the first one of its filter's docstring."""
    from meshfair import filters

    line = (getattr(filters, method.replace("-", "_")).__doc__ or "").partition("\n")[0]
    return re.sub(r" \[\w+\]_|, as an iterator", "", line).rstrip(".")


def known(method: str) -> dict[str, Any]:
    """The parameters that --set can give, and their defaults."""
    from meshfair import denoising

    if method == DEFAULT_METHOD:
        return {}
    defaults = denoising.defaults(method)
    defaults.pop("fixed", None)  # positions in arrays; --fix-boundary gives them
    return defaults


def chosen(options: argparse.Namespace) -> dict[str, Any]:
    """The parameters that were given, checked before a mesh is read.

    Parameters
    ----------
    options : argparse.Namespace
        Those of `meshfair denoise`. Messages will name its parameters as --set gives them.

    Returns
    -------
    dict

    Raises
    ------
    ValueError
        No such method or parameter; a value that is of a wrong type, or outside its range.
    """
    option_of = options.messages.option_of
    method = options.method
    defaults = known(method)
    has = f"{method} has {', '.join(defaults) or 'none'}"
    if method == DEFAULT_METHOD:
        has = "auto chooses all of them; name a --method, too"
    named = ("weights", "time", "strength")
    given = {name: getattr(options, name) for name in named if getattr(options, name) is not None}
    for name in given:
        if name not in defaults and name != "strength":
            raise ValueError(f"{option_of[name]} is no parameter of {method}; {has}")
    for name, text in options.set:
        if name not in defaults:
            remedy = f"{has}{did_you_mean(name, defaults)}"
            if name in option_of:
                remedy = f"it is the option {option_of[name]}"
            raise ValueError(f"--set {name}={text}: no such parameter; {remedy}")
        if name in given:
            raise ValueError(f"{name} is given twice; give it once")
        given[name] = _value(name, text, defaults[name])
    if options.sigma is not None and "noise" in given:
        raise ValueError("the noise is given twice, by --noise and by --set; give it once")
    option_of.update({name: f"--set {name}" for name in defaults if name not in option_of})
    if given or options.sigma is not None:
        _try(options, given)
    return given


def _value(name: str, text: str, default: Any) -> Any:
    """The value in a word, of the type that the default has."""
    if isinstance(default, str):
        return text
    if default is None and text == "None":
        return None
    kinds: list[Callable[[str], Any]] = [int, float]
    wanted = "a number or None" if default is None else "a number"
    if isinstance(default, bool):
        kinds, wanted = [{"true": True, "false": False}.__getitem__], "True or False"
        text = text.lower()
    elif isinstance(default, int):
        kinds, wanted = [int], "a whole number"
    for kind in kinds:
        with suppress(ValueError, KeyError):
            return kind(text)
    raise ValueError(f"--set {name} is {text!r}; give {wanted}")


def _try(options: argparse.Namespace, given: dict[str, Any]) -> None:
    """Refuse what is outside its range, before a large mesh is read: on a small one."""
    from meshfair import shapes
    from meshfair.denoising import denoise

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with suppress(MeshError, ArithmeticError):  # which are about the small mesh
            denoise(
                *shapes.icosphere(0),
                options.method,
                parameters=options.parameters,
                sigma=options.sigma,
                callback=lambda part: False,
                **given,
            )
