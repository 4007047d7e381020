"""Run the notebooks of the site, two at a time, and only those whose code has changed.

What a notebook shows depends on its cells and on the package: the cache stands in a folder named
after the package's sources, and within it each notebook is looked up by its cells.
"""

import asyncio
import hashlib
import os
import re
import shutil
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import jupytext
import nbclient
from jupyter_cache import get_cache
from jupyter_cache.base import CacheBundleIn
from nbformat import NotebookNode
from traitlets.config import Config

TIMEOUT = 600  # seconds a cell
KERNEL = {
    "MESHFAIR_PAGE": "1",  # meshes and explorers as they can be without a kernel
    "TQDM_DISABLE": "1",
    # One thread each: two run at a time, and BLAS threads would wait for each other.
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
}

# A warning of a cell begins with a file of the kernel's own, and ends with the line above it.
WARNING = re.compile(r"^\S*ipykernel\S*:\d+: (\w+: .*)\n( +.*\n?)?", re.MULTILINE)


def cache_folder(parent: Path, sources: Sequence[Path]) -> Path:
    """The folder of what was executed with these sources; those of other sources are dropped."""
    digest = hashlib.sha256()
    for source in sorted(sources):
        digest.update(source.read_bytes())
    folder = parent / digest.hexdigest()[:16]
    if parent.exists():
        for other in parent.iterdir():
            if other != folder:
                shutil.rmtree(other)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def execute(notebooks: Sequence[Path], folder: Path, scratch: Path) -> dict[Path, NotebookNode]:
    """Each notebook with its outputs, run only where the cache has no such cells."""
    cache = get_cache(folder)
    done, wanted = {}, {}
    for path in notebooks:
        notebook = jupytext.read(path)  # a page in Markdown may have cells, too
        try:
            match = cache.match_cache_notebook(notebook)
            done[path] = cache.get_cache_bundle(match.pk).nb
        except KeyError:
            wanted[path] = notebook
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    with ThreadPoolExecutor(2) as pool:
        runs = {path: pool.submit(_run, path, wanted[path], scratch) for path in wanted}
        for path, run in runs.items():
            done[path] = run.result()
            bundle = CacheBundleIn(done[path], str(path))
            cache.cache_notebook_bundle(bundle, check_validity=False, overwrite=True)
    return done


def _run(path: Path, notebook: NotebookNode, scratch: Path) -> NotebookNode:
    with tempfile.TemporaryDirectory() as sockets:
        # Through sockets that no other user can read, where there are such.
        private = {} if os.name == "nt" else {"transport": "ipc", "ip": f"{sockets}/kernel"}
        client = nbclient.NotebookClient(
            notebook,
            timeout=TIMEOUT,
            record_timing=False,  # times within the cells would be cells that have changed
            store_widget_state=False,  # pages run no widgets
            config=Config(KernelManager=private),
            resources={"metadata": {"path": str(scratch)}},
        )
        try:
            asyncio.run(client.async_execute(env={**os.environ, **KERNEL}))
        except nbclient.exceptions.CellExecutionError as error:
            raise SystemExit(f"{path.name} fails:\n{error}") from None
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            if output.get("name") == "stderr":
                output["text"] = WARNING.sub(r"\1\n", output["text"])
    print(f"  executed {path.name}", flush=True)
    return notebook
