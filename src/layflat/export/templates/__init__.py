"""Templates of exported files."""

from functools import cache
from importlib.resources import files
from typing import Any


def fill_template(name: str, /, **values: Any) -> str:
    """Return the text of a template with values.

    Args:
        name: name of the file without ".j2".
        values: values by their names in the template; jinja2.UndefinedError if one is missing.
    """
    return str(_environment().get_template(name).render(**values))


@cache
def _environment() -> Any:
    import jinja2  # noqa: PLC0415  # only where something is written

    def source(name: str) -> str:
        return (files(__package__) / f"{name}.j2").read_text(encoding="utf-8")

    return jinja2.Environment(
        loader=jinja2.FunctionLoader(source),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # the files are no pages of HTML
    )
