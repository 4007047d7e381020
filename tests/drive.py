"""Moves every control of every explorer, as a student would; run in a notebook's kernel too."""

from meshfair.explorers import Explorer


def positions(control):
    """The values to try: both ends of a slider, all entries of a menu, both states of a box."""
    if hasattr(control, "min"):
        return [control.min, control.max]
    if hasattr(control, "options"):
        return [name for _, name in control.options]
    return [True, False]


def drive(explorer):
    """Put each control of an explorer to each of its positions, and back again.

    Returns
    -------
    list of str
        "control = value: error" for each position at which the work failed.
    """
    failures = []
    for name, control in explorer.controls.items():
        before = control.value
        for value in positions(control):
            control.value = value
            explorer.wait()
            if explorer.error is not None:
                failures.append(f"{name} = {value}: {explorer.error!r}")
        control.value = before
    explorer.wait()
    return failures


def drive_all(names):
    """Drive the explorers among a notebook's variables; the number of controls that were moved.

    Raises
    ------
    AssertionError
        Some work failed.
    """
    explorers = [value for value in list(names.values()) if isinstance(value, Explorer)]
    failures = [failure for explorer in set(explorers) for failure in drive(explorer)]
    assert not failures, failures
    return sum(len(explorer.controls) for explorer in set(explorers))
