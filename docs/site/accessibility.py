"""Attributes for screen readers and keyboards that the theme and its extensions leave out of their HTML."""

import re
from pathlib import Path

MENDS = (
    (re.compile(r'<p class="caption" role="heading">'), '<p class="caption" role="heading" aria-level="2">'),
    (re.compile(r'<aside class="sidebar-drawer">'), '<aside class="sidebar-drawer" aria-label="All pages">'),
    (
        re.compile(r'<aside class="toc-drawer([^"]*)">'),
        r'<aside class="toc-drawer\1" aria-label="Contents of this page">',
    ),
    (re.compile(r'<div class="highlight"><pre>'), '<div class="highlight"><pre tabindex="0">'),  # it may scroll
    (
        re.compile(r'<a class="reference internal" href="([^"]+)"><span class="doc">([^<]+)</span></a></p>'),
        r'<a class="reference internal" href="\1" aria-label="\2"><span class="doc">\2</span></a></p>',
    ),  # a thumbnail covers its link's text
)


def mend_pages(folder: Path) -> None:
    """Complete the HTML of all pages of a built site."""
    for page in folder.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        for pattern, replacement in MENDS:
            text = pattern.sub(replacement, text)
        page.write_text(text, encoding="utf-8")
