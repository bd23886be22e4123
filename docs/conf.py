"""Sphinx: the documentation site (make docs). Nothing is fetched when it is read: MathJax is Debian's, copied beside it."""

import re
import shutil
from pathlib import Path

from porousmold import __version__

project, author, release = "porousmold", "the authors of porousmold", __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode", "sphinx.ext.mathjax", "sphinx_copybutton"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
html_theme, html_title = "furo", f"porousmold {__version__}"
html_static_path = ["_static"]
autodoc_typehints = "description"
autodoc_member_order = "bysource"
nitpicky = False

MATHJAX = Path("/usr/share/javascript/mathjax")
mathjax_path = "mathjax/MathJax.js"
mathjax2_config = {
    "extensions": ["tex2jax.js"],
    "jax": ["input/TeX", "output/SVG"],
    "TeX": {"extensions": ["AMSmath.js", "AMSsymbols.js", "noErrors.js", "noUndefined.js"]},
    "tex2jax": {"inlineMath": [["\\\\(", "\\\\)"]], "processClass": "math", "ignoreClass": ".*"},
}


def copy_mathjax(app, error):
    """The parts of MathJax that pages ask for: 5 MB of 54."""
    if error is not None:
        return
    target = Path(app.outdir) / "_static" / "mathjax"
    for part in ("MathJax.js", "jax/element", "jax/input/TeX", "jax/output/SVG", "extensions"):
        source = (MATHJAX / part).resolve()
        if source.is_dir():
            shutil.copytree(source, target / part, dirs_exist_ok=True)
        else:
            (target / part).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target / part)


def as_restructured_text(app, what, name, obj, options, lines):
    """Docstrings are plain text with tables and `names` as Markdown has them: tables stay as they stand, names are literals."""
    result, in_table = [], False
    for line in lines:
        table = line.lstrip().startswith("|") and line.rstrip().endswith("|")
        if table and not in_table:
            result += ["", "::", ""]
        elif in_table and not table:
            result.append("")
        in_table = table
        # `name`s: a literal ends before a letter
        text = re.sub(r"`+([^`]+)`+(\w?)", lambda m: f"``{m[1]}``" + (f"\\ {m[2]}" if m[2] else ""), line)
        result.append(f"    {line}" if table else text.replace("|", "\\|").replace("*", "\\*"))
    lines[:] = result


def setup(app):
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", as_restructured_text)
    app.connect("build-finished", copy_mathjax)
