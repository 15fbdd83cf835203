"""What people write: text, tables and quantities with units, validated into frozen objects.

Files of machines, test benches, cells, studies and mappings are schemas on top of it.
"""

from layflat.description.part import Part, ordered

__all__ = ["Part", "ordered"]
