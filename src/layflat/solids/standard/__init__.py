"""Tables of materials, standard parts, stock and processes: what a workshop can buy and do."""
