"""How loops become fast: compiled by numba, run in blocks on all cores.

A kernel is a plain Python function that loops over rows ``first .. last - 1``:

    @compiled
    def _double(first, last, x, out):
        for i in range(first, last):
            out[i] = 2 * x[i]

    on_all_cores(_double, len(x), x, out)

A formula that several kernels share is a `helper`.

The cores are used by ordinary Python threads, since compiled code does not
hold the interpreter's lock. So kernels may be called from several threads at
once, and in processes that were forked or spawned. numba's own ``parallel=True``
allows that only with thread libraries that not every installation has.
"""

import functools
import os
from concurrent.futures import ThreadPoolExecutor

import numba

from meshfair import _fast

# Rows a thread takes at a time. The same on every machine, so that sums over
# blocks do not depend on the number of cores.
BLOCK = 16_384


def compiled(kernel=None, *, fused=False):
    """Let numba compile a kernel at its first call, and keep the machine code on disk.

    Parameters
    ----------
    kernel : function of NumPy arrays and numbers
        Left out where options are given: ``@compiled(fused=True)``.
    fused : bool
        Let a product and the sum that it goes into be rounded once, where the
        processor can do so (fused multiply-add). Sums over neighbours are up to
        a sixth quicker; their last digit then depends on the processor.

    Returns
    -------
    numba dispatcher
        Called like ``kernel``. Its ``py_func`` is the Python function.
    """
    if kernel is None:
        return functools.partial(compiled, fused=fused)
    # "numpy": a division by zero gives inf or NaN, as it does in NumPy.
    return numba.njit(
        kernel, nogil=True, cache=True, error_model="numpy",
        fastmath={"contract"} if fused else False,
    )  # fmt: skip


def helper(function):
    """Let kernels share a function: its text is put into each of them.

    A call would pass arrays with their reference counts, which takes as long as a row.
    """
    return numba.njit(function, inline="always")


def unsigned(*indices):
    """Index arrays as unsigned integers, in the same memory.

    numba asks of every signed index whether it is negative and counts from the
    end, as in NumPy. In a kernel that gathers, that takes as long as all else.

    Parameters
    ----------
    *indices : ndarray of integers, all at least 0

    Returns
    -------
    list of ndarray
    """
    return [index.view(index.dtype.str.replace("i", "u")) for index in indices]


@functools.cache
def threads():
    """How many cores to use: those this process may use, or NUMBA_NUM_THREADS."""
    return numba.config.NUMBA_NUM_THREADS


@functools.cache
def _helpers():
    return ThreadPoolExecutor(threads() - 1, thread_name_prefix="meshfair")


# The threads do not survive a fork; the child starts its own.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)


def on_all_cores(kernel, count, *arguments, block=BLOCK):
    """Run ``kernel(first, last, *arguments)`` over the blocks of range(count).

    Parameters
    ----------
    kernel : function
        Made by `compiled`. Blocks run at the same time, so no two of them may
        write to the same place.
    count : int
        Number of rows.
    *arguments
        Passed on to the kernel.
    block : int
        Number of rows that a thread takes at a time.

    Returns
    -------
    list
        What the kernel returned for each block, in the order of the blocks.
    """
    firsts = range(0, count, block)
    results = [None] * len(firsts)
    blocks = iter(enumerate(firsts))  # shared: each thread takes the next one

    def work():
        for k, first in blocks:
            results[k] = kernel(first, min(first + block, count), *arguments)

    alone = len(firsts) < 2 or _fast.one_core()
    busy = 1 if alone else min(threads(), len(firsts))
    helpers = [_helpers().submit(work) for _ in range(busy - 1)]
    work()
    for helper in helpers:
        if not helper.cancel():  # it did start
            helper.result()
    return results
