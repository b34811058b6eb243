"""Equations of docstrings become TeX on the site."""

import importlib.util
from pathlib import Path

import pytest

FILE = Path(__file__).resolve().parents[2] / "docs" / "equations.py"
SPEC = importlib.util.spec_from_file_location("equations", FILE)
equations = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(equations)


@pytest.mark.parametrize(
    ("plain", "tex"),
    [
        ("K = P H' Z^-1,    x = x + K z", r"K = P H ^\top Z ^{-1},\quad x = x + K z"),
        ("P_rr = X_x P_rr X_x'", r"P_{rr} = X_{x} P_{rr} X_{x} ^\top"),
        ("sigma_d = sigma_rho / rho^2", r"\sigma_{d} = \sigma_{\rho} / \rho ^{2}"),
        ("x2 = sin(a) v dt / track", r"x_{2} = \sin (a ) v \Delta t / \text{ track }"),
        ("W = P H' L^-T.", r"W = P H ^\top L ^{-\top}"),
    ],
)
def test_plain_letters_become_tex(plain, tex):
    assert equations.tex(plain).split() == tex.split()


def test_only_equations_are_taken():
    text = [
        "Motion.",
        "",
        "    P = F P F'",
        "",
        "    >>> x = 1",
        "",
        "    if x == 2:",
        "",
        "Parameters",
        "----------",
        "x : a",
    ]
    out = equations.rendered(text)
    assert out[2:5] == [".. math::", "", "    P  = F  P  F ^\\top"] and out[5:] == text[3:]
