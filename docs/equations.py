"""Equations of the docstrings for the site: from the plain letters of the source to TeX.

A docstring has its equations as indented lines, for example ``K = P H' Z^-1``, to be read in an editor. A line of its
own with an equals sign between blank lines is such an equation; here it becomes a ``.. math::`` block.
"""

import re

GREEK = {"alpha", "beta", "theta", "sigma", "rho", "phi", "psi"}
FUNCTIONS = {"sin", "cos", "tan", "log", "exp"}
WORDS = {"at", "of", "or", "by"}  # of two letters; others of two letters are pairs of states: rm, ll
CODE = re.compile(r">>>|\*\*|\"|==|\bfor\b|\bimport\b|\w\.\w|::|#|\(\)")
TOKEN = re.compile(r"\^-?\w+|[A-Za-z]+\d*(?:_[A-Za-z0-9]+)?|'|\.\.\.|\.$| {2,}| |.")


def render(app, what, name, obj, options, lines):
    """Replace the equations of a docstring; for Sphinx's event `autodoc-process-docstring`."""
    lines[:] = rendered(lines)


def rendered(lines):
    """Return the lines with their equations as math blocks."""
    out = []
    for before, line, after in zip(["", *lines], lines, [*lines[1:], ""], strict=False):
        if (
            line.startswith("    ")
            and "=" in line
            and not before.strip()
            and not after.strip()
            and not CODE.search(line)
        ):
            out += [".. math::", "", "    " + tex(line.strip())]
        else:
            out.append(line)
    return out


def tex(text):
    """Return an equation in plain letters as TeX."""
    return "".join(_tex(token) for token in TOKEN.findall(text)).strip()


def _tex(token):
    if token.startswith("^"):
        power = token[1:].replace("T", r"\top")
        return f"^{{{power}}}"
    if token[0].isalpha():
        name, _, sub = token.partition("_")
        return _name(name) + (f"_{{{_name(sub)}}}" if sub else "") + " "
    words = {"'": r"^\top ", "...": r"\dots ", ".": "", "[": "[", " ": " "}
    return r"\quad " if token.isspace() and len(token) > 1 else words.get(token, token)


def _name(word):
    """A name: Greek, a function, one letter, a letter with a number, or a word."""
    letters = word.rstrip("0123456789")
    if letters == "dt":
        return r"\Delta t"
    if letters in GREEK or letters in FUNCTIONS:
        head = "\\" + letters
    else:
        head = letters if len(letters) <= 2 and letters not in WORDS else rf"\text{{ {letters} }}"
    digits = word[len(letters) :]
    return f"{head}_{{{digits}}}" if digits and letters else head + digits
