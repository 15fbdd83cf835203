"""A packing cell whose deliveries are two ripe tomatoes each."""

FEW = """\
extends = "packing"
name = "few"

[tray.infeed]
produce = ["tomato"]
count = { least = 2, most = 2 }

[produce.tomato.diameter]
least = "54 mm"

[produce.tomato.colour.orange]
share = 0.000001
"""
