"""The page that joins the numbers and pictures of a report."""

import html
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Picture:
    """A picture of a report and what stands below it."""

    file: str
    title: str
    caption: str


_CSS = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1f2937; max-width: 1180px; margin: 2rem auto;
       padding: 0 1rem; }
table { border-collapse: collapse; margin: 1rem 0; }
td { padding: .25rem 1rem .25rem 0; border-bottom: 1px solid #e5e7eb; vertical-align: top; }
td:first-child { color: #6b7280; white-space: nowrap; }
img { max-width: 100%; border: 1px solid #e5e7eb; }
figcaption { color: #6b7280; } figure { margin: 0 0 2rem 0; }
"""


def html_page(title: str, rows: list[tuple[str, str]], pictures: Sequence[Picture]) -> str:
    """One page: a table of facts, then the pictures with their captions."""
    cells = "\n".join(
        f"<tr><td>{html.escape(name)}</td><td>{html.escape(value)}</td></tr>"
        for name, value in rows
    )
    figures = "\n".join(
        f"<h2>{html.escape(p.title)}</h2>\n"
        f'<figure><img src="{p.file}" alt="{html.escape(p.title)}">'
        f"<figcaption>{html.escape(p.caption)}</figcaption></figure>"
        for p in pictures
    )
    return (
        f'<!doctype html>\n<html lang="en">\n<head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title><style>{_CSS}</style></head>\n<body>\n"
        f"<h1>{html.escape(title)}</h1>\n<table>\n{cells}\n</table>\n{figures}\n"
        f'<p>All numbers: <a href="summary.json">summary.json</a></p>\n</body>\n</html>\n'
    )


def markdown_page(title: str, rows: list[tuple[str, str]], pictures: Sequence[Picture]) -> str:
    """The same as Markdown."""
    table = "\n".join(f"| {name} | {value.replace('|', chr(92) + '|')} |" for name, value in rows)
    figures = "\n\n".join(
        f"## {p.title}\n\n![{p.title}]({p.file})\n\n{p.caption}" for p in pictures
    )
    return (
        f"# {title}\n\n| | |\n| --- | --- |\n{table}\n\n{figures}\n\n"
        "All numbers: [summary.json](summary.json)\n"
    )
