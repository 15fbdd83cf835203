"""Joints and arms as things on a bench: solids, drawings, lists, and the documents of air, wires and first start."""
