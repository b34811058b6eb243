"""How a map looks in a notebook: its states, and the correlations between them as a picture in plain SVG."""

import html

import numpy as np

CELLS = 60  # most rows and columns of the picture: more cannot be seen apart
SIDE = 300  # of the picture, px
RED, BLUE = (213, 94, 0), (0, 114, 178)  # positive and negative, of the palette of Okabe and Ito


def map_html(map, owners=None):
    """Return a map as HTML: one line per state, and the correlation matrix with the blocks of the states.

    Parameters
    ----------
    map : Map
    owners : dict of str to slice, optional
        Whose state is where; without it the ranges speak for themselves.
    """
    owners = owners or {f"{r.start}:{r.stop}": r for r in map.ranges}
    rows = [(name, f"{r.start}:{r.stop}", *_numbers(map, r)) for name, r in owners.items()]
    table = table_html(("state", "range", "mean", "sigma"), rows)
    return (
        f"<b>{html.escape(repr(map))}</b>"
        f'<div style="display:flex;gap:2em;align-items:flex-start;flex-wrap:wrap">{_picture(map, owners)}'
        f'<div style="max-height:{SIDE}px;overflow:auto">{table}</div></div>'
    )


def table_html(heads, rows):
    """Return a table as HTML; every cell is text."""
    cells = lambda tag, row: "".join(f"<{tag}>{html.escape(str(value))}</{tag}>" for value in row)
    body = "".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    return f"<table><thead><tr>{cells('th', heads)}</tr></thead><tbody>{body}</tbody></table>"


def _numbers(map, r):
    sigma = np.sqrt(np.maximum(np.diag(map.block(r)), 0.0))
    return tuple(" ".join(f"{v:.3g}" for v in values) for values in (map.state(r), sigma))


def _picture(map, owners):
    """Correlations as squares, the darker the stronger; lines between the states."""
    indices = np.flatnonzero(map.used)
    n = len(indices)
    if not n:
        return ""
    shown = indices[:: -(-n // CELLS)]  # every state, or every second, third ...
    P = map.P[np.ix_(shown, shown)]
    sigma = np.sqrt(np.maximum(np.diag(P), 0.0))
    C = np.divide(P, np.outer(sigma, sigma), out=np.zeros_like(P), where=np.outer(sigma, sigma) > 0)
    size = SIDE / len(shown)
    squares = "".join(
        f'<rect x="{j * size:.1f}" y="{i * size:.1f}" width="{size:.1f}" height="{size:.1f}" '
        f'fill="rgb{RED if C[i, j] > 0 else BLUE}" fill-opacity="{min(abs(C[i, j]), 1):.2f}"/>'
        for i, j in np.argwhere(np.abs(C) > 0.01)
    )
    borders = [np.searchsorted(indices, r.start) * SIDE / n for r in owners.values()] if len(owners) <= CELLS else []
    lines = "".join(
        f'<path d="M{at:.1f} 0V{SIDE}M0 {at:.1f}H{SIDE}" stroke="#777" stroke-width="0.7"/>' for at in borders
    )
    words = f"Correlations between the {n} states of the map: orange positive, blue negative."
    return (
        f'<svg width="{SIDE}" height="{SIDE}" viewBox="0 0 {SIDE} {SIDE}" role="img" aria-label="{words}" '
        f'style="background:white;border:1px solid #777;flex:none"><title>{words}</title>{squares}{lines}</svg>'
    )
