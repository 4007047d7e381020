"""The notebooks as pages of a course."""

import json
import re
from pathlib import Path
from typing import Any

from links import Links


def course(folder: Path) -> list[Path]:
    """The notebooks in their order."""
    return sorted(folder.glob("[0-9][0-9]-*.ipynb"))


def read(path: Path) -> dict[str, Any]:
    """A notebook."""
    return json.loads(path.read_text(encoding="utf-8"))


def title(path: Path) -> str:
    """Its heading, such as ``1 · Noise and the signal-to-noise ratio``."""
    first = "".join(read(path)["cells"][0]["source"])
    return first.partition("\n")[0].removeprefix("# ")


def goal(path: Path) -> str:
    """The sentence at its beginning that says what it is for."""
    first = "".join(read(path)["cells"][0]["source"])
    found = re.search(r"\*\*Goal\.\*\* (.*)", first)
    if not found:
        raise ValueError(f"{path.name} does not begin with its goal")
    return found[1]


def of_course(path: Path, links: Links) -> str:
    """A notebook of the course with links between pages in place of those between files."""
    return _page(path, f"notebooks/{path.name}", links)


def of_assignment(path: Path, links: Links) -> str:
    """A student's notebook, as it is before anything has been filled in."""
    return _page(path, f"assignments/{path.name}", links)


def _page(path: Path, page: str, links: Links) -> str:
    notebook = read(path)
    for cell in notebook["cells"]:
        if cell["cell_type"] != "markdown":
            continue
        text = "".join(cell["source"])
        text = re.sub(r"\n+<!-- links -->\n.*", "", text)  # to this very page
        text = re.sub(r"\*\*(Next|Back):\*\*.*", "", text)  # the page has its own
        cell["source"] = links.rewrite(text, path, page).rstrip()
    return json.dumps(notebook, indent=1, ensure_ascii=False)
