"""Sphinx's settings. Pages that repeat what the project already says are generated when a build begins."""

import re
import sys
from html import escape
from pathlib import Path

import ziamath
from docutils.nodes import SkipNode
from sphinx_gallery.sorting import FileNameSortKey

sys.path.insert(0, str(Path(__file__).parent))

import vibroimpact
from generate import benchmarks, checks, corrections, fortran, namelist, programs, python, studies

project = "vibroimpact"
author = "The vibroimpact authors"
copyright = author  # noqa: A001
release = version = vibroimpact.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = [
    "benchmarks.md", "examples", "generate", "paper", "sg_execution_times.rst",
    "generated/[!p]*", "generated/python.md", "generated/programs.md",
]  # fmt: skip
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3
suppress_warnings = ["config.cache"]

autodoc_member_order = "bysource"
autodoc_mock_imports = ["jax"]
autodoc_typehints = "none"  # the docstrings say it in words
napoleon_numpy_docstring = True
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
default_role = "code"  # as docstrings use it

sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "gallery",
    "within_subsection_order": FileNameSortKey,
    "abort_on_example_error": True,
    "remove_config_comments": True,
    # what an example prints depends on the package, not only on the script
    "run_stale_examples": True,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 3600,
    "write_computation_times": False,
    "download_all_examples": False,
    "image_scrapers": ("matplotlib",),
    "image_srcset": ["2x"],
    "capture_repr": (),
}

smartquotes_action = "De"  # dashes and ellipses alone: primes are derivatives
html_theme = "furo"
html_title = "vibroimpact"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0072B2", "color-brand-content": "#0072B2"},
    "dark_css_variables": {"color-brand-primary": "#56B4E9", "color-brand-content": "#56B4E9"},
}


def show_math(translator, node):
    """Write a formula as a drawing in the page: no script and no font is loaded for it.

    The parts of a block with \\qquad between them are drawings of their own, which wrap on a narrow screen.
    """
    block = node.tagname == "math_block"
    parts = node.astext().split(r"\qquad") if block else [node.astext()]
    drawings = "".join(drawn(part.strip(), block) for part in parts)
    translator.body.append(f'<div class="math">{drawings}</div>' if block else drawings)
    raise SkipNode


def drawn(tex, block):
    """The drawing of a formula, as SVG."""
    # without an empty group before it the subscript of a P is drawn into the letter
    plain = re.sub(r"P_(?:{([^}]*)}|(\w))", r"P_{{}\1\2}", tex)
    drawing = ziamath.Latex(plain, size=16, color="currentColor", inline=not block)
    _, _, width, height = (float(x) for x in drawing.svgxml().attrib["viewBox"].split())
    # in em: a formula grows with the text around it
    style = f"width: {width / 15:.3f}em; height: {height / 15:.3f}em; vertical-align: {depth(drawing):.3f}em"
    return drawing.svg().replace(
        "<svg ", f'<svg role="img" aria-label="{escape(tex, quote=True)}" style="{style}" ', 1
    )


def depth(drawing):
    """How far a drawing reaches below the line, negative, in em."""
    _, top, _, height = (float(x) for x in drawing.svgxml().attrib["viewBox"].split())
    return -(top + height) / 15


def generate_pages(app):
    """Write the generated pages, each only if it changed."""
    folder = Path(app.srcdir) / "generated"
    folder.mkdir(exist_ok=True)
    pages = {}
    for module in (benchmarks, checks, corrections, fortran, namelist, programs, python, studies):
        pages |= module.pages()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
    for path in folder.iterdir():
        if path.name not in pages:
            path.unlink()


#: A parameter as napoleon writes it: its name, its text, and its type if there is one.
PARAMETER = r"^:param ([^:]+): ?(.*(?:\n +.*)*)(?:\n:type \1: (.*))?$"


def merge_parameters(lines):
    """Give neighbouring parameters of one text and type, which napoleon takes apart, one entry again."""
    out, before = [], None
    text = "\n".join(lines)
    end = 0
    for found in re.finditer(PARAMETER, text, re.MULTILINE):
        between, end = text[end : found.start()], found.end()
        name, said, kind = found[1], " ".join(found[2].split()), found[3]
        if before and before[1:] == (said, kind) and between == "\n":
            out.pop()
            name = f"{before[0]},\N{ZERO WIDTH SPACE}{name}"
        else:
            out.append(between)
        out.append(f":param {name}: {said}" + (f"\n:type {name}: {kind}" if kind else ""))
        before = (name, said, kind)
    lines[:] = ("".join(out) + text[end:]).split("\n")


def mend_docstring(app, what, name, thing, options, lines):
    """Keep what Sphinx and napoleon would take for markup: bars, a colon, names in common.

    max|x|/A would be a substitution, the words before a property's first colon its type, and of the names
    `X, Z` all but the last one the type of that.
    """
    merge_parameters(lines)
    if what == "property" and lines and lines[-1].startswith(":type: "):
        lines[:] = [f"{lines[-1].removeprefix(':type: ')}: {lines[0]}", *lines[1:-1]]
    for i, line in enumerate(lines):
        field = re.match(r":(?:ivar|vartype) ([^:]*):", line)
        if field:
            lines[i] = line.replace(field[1], field[1].replace(", ", ",\N{ZERO WIDTH SPACE}"), 1)
    example = False
    for i, line in enumerate(lines):
        example = bool(line.strip()) and (example or line.lstrip().startswith(">>>"))
        if not example:
            lines[i] = line.replace("|", r"\|")


def setup(app):
    """Register what this file adds."""
    app.connect("autodoc-process-docstring", mend_docstring)
    app.connect("config-inited", lambda app, config: generate_pages(app))
    app.add_html_math_renderer("drawn", (show_math, None), (show_math, None))


html_math_renderer = "drawn"
ziamath.config.svg2 = False  # no names within a drawing, which would stand in the page twice
