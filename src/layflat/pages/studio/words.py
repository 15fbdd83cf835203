"""Names and notes that the page shows beside values."""

from layflat.pages.studio.field import titled

NOTES = {
    "paper": "from the paper",
    "derived": "follows from other values",
    "assumed": "assumed",
    "calibrated": "found by a calibration",
    "identified": "identified from measurements",
    "given": "the file does not say where it comes from",
    "default": "not in the file: the usual value",
    "edited": "changed here",
}
"""What a source means, where it has no note of its own."""


def place_of(section: str) -> str:
    """Return the name of a section, such as "Joint large, hose"."""
    first, *keys = section.split(".")
    if first == "joint":
        return ", ".join([f"Joint {keys[0]}", *(titled(key).lower() for key in keys[1:])])
    return ", ".join([titled(first), *(f"link {key}" for key in keys[1:])])  # "arm.link.base"


def sentence(meaning: str, limits: str) -> str:
    """Return meaning and limits of a value as one line."""
    meaning = meaning.replace("`", "")
    text = f"{meaning}; {limits}" if meaning and limits else meaning or limits
    return text[:1].upper() + text[1:]
