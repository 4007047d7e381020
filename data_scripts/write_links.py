"""Write the links at the beginning of each notebook: to its page of the site, and to Binder.

The addresses are those of ``[project.urls]`` in pyproject.toml: ``Repository``, ``Documentation``.
Without them the page is the one that `make site` builds, and no Binder is named.
"""

import json
import re
import tomllib
from pathlib import Path
from urllib.parse import quote, urlsplit

ROOT = Path(__file__).resolve().parent.parent
MARK = "<!-- links -->"
BINDER = "https://mybinder.org/v2"


def line(name: str, urls: dict[str, str]) -> str:
    """The line of one notebook."""
    page = f"notebooks/{Path(name).stem}.html"
    site = urls.get("Documentation", "../report/site").rstrip("/")
    built = "" if "Documentation" in urls else " (once `make site` has built it)"
    links = [f"[This notebook as a page]({site}/{page}){built}"]
    if repository := urls.get("Repository", "").rstrip("/"):
        path = urlsplit(repository).path.strip("/")
        github = urlsplit(repository).netloc == "github.com"
        place = f"gh/{path}/main" if github else f"git/{quote(repository, safe='')}/main"
        where = quote(f"lab/tree/notebooks/{name}", safe="")
        links.append(f"[run it on Binder]({BINDER}/{place}?urlpath={where})")
    return " · ".join(links)


def with_links(text: str, name: str, urls: dict[str, str]) -> str:
    """A notebook's first cell with its line of links, in place of an earlier one."""
    rest = re.sub(rf"\n+{MARK}\n.*", "", text).rstrip()
    return f"{rest}\n\n{MARK}\n{line(name, urls)}"


def addresses() -> dict[str, str]:
    """What pyproject.toml says."""
    pyproject = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return pyproject["project"].get("urls", {})


def main() -> None:
    """Write those notebooks whose links are not as they should be."""
    for path in sorted((ROOT / "notebooks").glob("[0-9][0-9]-*.ipynb")):
        before = path.read_text(encoding="utf-8")
        notebook = json.loads(before)
        cell = notebook["cells"][0]
        text = with_links("".join(cell["source"]), path.name, addresses())
        cell["source"] = text.splitlines(keepends=True)
        after = json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"
        if after != before:
            path.write_text(after, encoding="utf-8")
            print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
