"""Fast equals plain: the one idea by which every compiled loop is tested.

A public function says in NumPy what it computes, and hands large meshes to a
compiled loop. `both` calls it in either form, whatever the size.
"""

from unittest import mock

from meshfair import _fast


def both(function):
    """What a function of no arguments returns in NumPy, and with compiled loops."""
    results = []
    for fast in (False, True):
        with mock.patch.object(_fast, "wanted", return_value=fast):
            results.append(function())
    return results
