"""Texts of the repository as pages: their links lead to pages, where there are such."""

import os
import re
import tomllib
from pathlib import Path

# Files of the repository that are pages, or whose sections are.
PAGES = {
    "README.md": "start",
    "CONTRIBUTING.md": "contributing",
    "CONTRIBUTING.md#glossary": "glossary",
    "CHANGELOG.md": "changes",
    "CITATION.cff": "cite",
    "notebooks/SWEEPS.md": "sweeps",
    "notebooks/assignments/TEACHING.md": "assignments/teaching",
    "report/report.pdf": "report",
}


class Links:
    """What leads where, in texts that stand elsewhere in the repository."""

    def __init__(self, root: Path) -> None:
        self.root = root
        pyproject = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
        self.repository: str = pyproject["project"].get("urls", {}).get("Repository", "")
        """Where the sources can be seen; empty as long as the project names no such place."""

    def rewrite(self, text: str, origin: Path, page: str) -> str:
        """Markdown of the file ``origin``, to stand on a page."""

        def replace(match: re.Match[str]) -> str:
            words, target = match[1], match[2]
            if re.match(r"[a-z]+:|#", target):
                return match[0]
            file, _, anchor = target.partition("#")
            name = os.path.relpath(origin.parent / file, self.root)
            to = self.page(name, anchor)
            if to:
                place = os.path.relpath(to, Path(page).parent)
                return f"[{words}]({place.replace(os.sep, '/')})"
            if self.repository and (self.root / name).exists():
                return f"[{words}]({self.repository}/blob/main/{name})"
            return words  # a place that no page has

        return re.sub(r"(?<!!)\[((?:[^\[\]]|\[[^\]]*\])+)\]\(([^)\s]+)\)", replace, text)

    def page(self, name: str, anchor: str = "") -> str:
        """The page of a file of the repository, with its suffix, or an empty string."""
        name = name.replace(os.sep, "/")
        if f"{name}#{anchor}" in PAGES:
            return PAGES[f"{name}#{anchor}"] + ".md"
        if re.fullmatch(r"notebooks/[^/]+\.ipynb", name):
            return name
        if match := re.fullmatch(r"notebooks/assignments/student/\w+/(\w+\.ipynb)", name):
            return f"assignments/{match[1]}"
        if name in PAGES:
            # Anchors are those of a page that holds the whole file.
            keep = anchor and name not in ("README.md",)
            return PAGES[name] + ".md" + (f"#{anchor}" if keep else "")
        return ""

    def whole(self, name: str, page: str) -> str:
        """All of a Markdown file."""
        path = self.root / name
        return self.rewrite(path.read_text(encoding="utf-8"), path, page)

    def section(self, name: str, heading: str, page: str) -> str:
        """What stands under one heading of a Markdown file, without the heading."""
        text = (self.root / name).read_text(encoding="utf-8")
        found = re.search(rf"^## {re.escape(heading)}\n(.*?)(?=^## |\Z)", text, re.M | re.S)
        if not found:
            raise ValueError(f"{name} has no section '{heading}'")
        return self.rewrite(found[1].strip("\n"), self.root / name, page)
