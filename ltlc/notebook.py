"""HTML by which values show themselves in a notebook: a heading, a table, and pictures; in light and dark alike."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def fragment(heading: str, rows: Iterable[Sequence[str]] = (), *, titles: Sequence[str] = (), picture: str = "") -> str:
    """A heading, a picture and a table as HTML.

    Args:
        heading: a sentence, as text.
        rows: cells of the table, as text.
        titles: of its columns, as text.
        picture: SVG, as `to_svg` of an automaton gives it; it stands on white, for which it was drawn.

    Example:
        >>> fragment("1 < 2", [("size", "3")])
        '<div><p><b>1 &lt; 2</b></p><table><tbody><tr><td>size</td><td>3</td></tr></tbody></table></div>'
    """
    parts = [f"<div><p><b>{escape(heading)}</b></p>"]
    if picture:
        svg = picture[max(picture.find("<svg"), 0) :]
        parts.append(f'<div style="background:white;display:inline-block;max-width:100%;overflow-x:auto">{svg}</div>')
    head = "".join(f"<th>{escape(title)}</th>" for title in titles)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    if body:
        parts.append("<table>" + (f"<thead><tr>{head}</tr></thead>" if head else "") + f"<tbody>{body}</tbody></table>")
    return "".join([*parts, "</div>"])


def bar(low: float, value: float, high: float, best: float | None = None) -> str:
    """A probability as a bar from 0 to 1, with what is uncertain of it in a paler colour, and a line at the best one.

    Example:
        >>> bar(0.2, 0.25, 0.3, best=0.5).count("<rect")
        3
    """
    rects = [
        '<rect width="200" height="12" fill="#e4e4e4"/>',
        f'<rect width="{200 * high:.2f}" height="12" fill="#9fc7a5"/>',
        f'<rect width="{200 * low:.2f}" height="12" fill="#3c8d5a"/>',
    ]
    line = "" if best is None else f'<path d="M{200 * best:.2f} 0v12" stroke="#222222" stroke-width="2"/>'
    title = f"<title>{value:.4g} between {low:.4g} and {high:.4g}</title>"
    start = '<svg xmlns="http://www.w3.org/2000/svg" width="200" height="12" role="img">'
    return "".join([start, title, *rects, line, "</svg>"])
