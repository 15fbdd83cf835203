"""A packing cell whose deliveries are two ripe tomatoes each."""

FEW = """\
extends = "packing"
name = "few"

[tray.infeed]
produce = ["tomato"]
count = { min = 2, max = 2 }

[produce.tomato.diameter]
min = "54 mm"

[produce.tomato.colour.orange]
fraction = 0.000001
"""
