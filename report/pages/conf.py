"""How Sphinx builds the site; `make site` says where from and where to."""

import os
import re
import shutil
import sys
from importlib import metadata
from pathlib import Path

from sphinx.application import Sphinx

import meshfair

PAGES = Path(__file__).resolve().parent
sys.path.insert(0, str(PAGES))

import public  # noqa: E402

project = "meshfair"
author = "the meshfair authors"
copyright = author
release = version = meshfair.__version__
language = "en"

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinxcontrib.bibtex",
    "docstrings",
]
source_suffix = {".md": "myst-nb", ".ipynb": "myst-nb"}
exclude_patterns = ["jupyter_execute"]
suppress_warnings = [
    "mystnb.unknown_mime_type",  # widgets stand beside what a page without a kernel can show
]

# Notebooks: executed before Sphinx starts, two at a time (execution.py); here they are looked up.
nb_execution_mode = "cache"
nb_execution_cache_path = os.environ["MESHFAIR_EXECUTED"]
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_execution_excludepatterns = ["assignments/*"]  # of which nothing is done yet
nb_merge_streams = True
nb_ipywidgets_js = {}  # nothing from a CDN
nb_number_source_lines = False
myst_enable_extensions = ["attrs_block", "attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4

# The reference.
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings say it with shapes and units
autodoc_preserve_defaults = True
autodoc_class_signature = "mixed"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
numpydoc_validation_checks = {"GL08", "PR01", "PR02", "RT01", "SS01"}
# Of records, each field says itself what it is; of widgets, the arguments are those of their base.
numpydoc_validation_exclude = {rf"^{re.escape(name)}$" for name in public.described_by_fields()}
bibtex_bibfiles = [str(PAGES.parent / "references.bib")]
bibtex_default_style = "alpha"
bibtex_reference_style = "author_year"

# The look.
html_theme = "pydata_sphinx_theme"
html_title = "meshfair"
player = Path(os.environ["MESHFAIR_PLAYER"])  # what meshes need in a page without a kernel
html_static_path = [str(PAGES / "static"), str(player)]
html_css_files = ["site.css", *(path.name for path in player.glob("*.css"))]
html_js_files = [path.name for path in player.glob("*.js")]
html_favicon = str(PAGES / "static" / "favicon.svg")
html_show_sourcelink = False
html_copy_source = False
html_show_sphinx = False
html_show_search_summary = False  # it would be fetched, which pages from file:// may not
NO_CONTENTS = (  # pages without others below them
    "index", "start", "which-filter", "report", "speed", "sweeps", "glossary", "bibliography",
    "cite", "changes", "contributing",
)  # fmt: skip
html_sidebars: dict[str, list[str]] = {page: [] for page in NO_CONTENTS}
html_theme_options = {
    "logo": {"text": "meshfair", "image_light": html_favicon, "image_dark": html_favicon},
    "header_links_before_dropdown": 6,
    "navbar_persistent": ["search-button"],
    "navigation_with_keys": False,  # the arrows turn the meshes
    "show_prev_next": True,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
html_context = {"default_mode": "auto"}
copybutton_prompt_text = r">>> |\.\.\. "
copybutton_prompt_is_regexp = True
copybutton_exclude = ".linenos, .gp"

# Formulas: MathJax from its package, with glyphs as SVG, so that a page needs no font file.
MATHJAX = "mathjax/static/mathjax/es5/tex-svg.js"
mathjax_path = "tex-svg.js"
mathjax3_config = {"options": {"enableMenu": False}, "svg": {"fontCache": "local"}}


def copy_mathjax(app: Sphinx, error: Exception | None) -> None:
    """Put MathJax beside the pages."""
    if error is None:
        source = metadata.distribution("django-static-mathjax").locate_file(MATHJAX)
        shutil.copyfile(str(source), Path(app.outdir) / "_static" / "tex-svg.js")


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect("build-finished", copy_mathjax)
    # What the reference is made with: a change of it makes all pages anew.
    made_with = [(PAGES / name).read_text() for name in ("docstrings.py", "formulas.toml")]
    app.add_config_value("reference_made_with", "".join(made_with), "env")
