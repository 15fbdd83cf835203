"""Pages that need nothing else: one look for all, figures inside."""

from dataclasses import dataclass
from importlib.resources import files
from typing import Any


@dataclass(frozen=True)
class Drawn:
    """A figure of a page, as SVG, with its caption."""

    id: str
    title: str
    caption: str
    svg: str

    def __html__(self) -> str:
        """Return the figure as a template puts it in: its drawing as it is, its words escaped."""
        from markupsafe import escape  # noqa: PLC0415

        caption = f"<figcaption><b>{escape(self.title)}</b> {escape(self.caption)}</figcaption>"
        return f'<figure id="{escape(self.id)}">\n{self.svg}\n{caption}\n</figure>'


def page(package: str, template: str, **values: Any) -> str:
    """Render a template of a package, which extends `page.html.j2` of this one, as HTML."""
    import jinja2  # noqa: PLC0415

    def source(name: str) -> str:
        home = "layflat.plot" if name == "page.html.j2" else package
        return (files(home) / name).read_text(encoding="utf-8")

    loader = jinja2.FunctionLoader(source)
    environment = jinja2.Environment(loader=loader, autoescape=True, undefined=jinja2.StrictUndefined)
    return environment.get_template(template).render(**values)
