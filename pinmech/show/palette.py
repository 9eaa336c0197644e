"""The colours of all that is drawn: plots, meshcat scenes and the pages around them."""

from __future__ import annotations

#: Curves: colours that colour-blind readers tell apart (M. Okabe, K. Ito, 2008).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
#: Line styles, for curves beyond the last colour.
STYLES = ("-", "--", ":", "-.")
#: Grid and zero line of a plot, and what stands where there is no curve.
GRID, ZERO, FAILED = "0.9", "0.6", "#a40000"

#: Colours of a scene, as meshcat takes them. The axes of a frame:
AXES = {"x": 0xD62728, "y": 0x2CA02C, "z": 0x1F5FD6}
#: The platform normal, and the trace of its tip.
NORMAL = 0xC2189B
#: Links without a shape.
STICK = 0x7A8794
#: A closure that is closed, and one that gapes: red, green, blue from 0 to 1.
CLOSED, OPEN = (0.10, 0.62, 0.20), (0.86, 0.08, 0.08)
#: Sky of a scene, top and bottom, and its grid (red, green, blue, opacity).
SKY = ((0.97, 0.98, 1.0), (0.78, 0.83, 0.89))
FLOOR = (1.0, 1.0, 1.0, 0.35)
#: Text and its box on a scene's page.
TEXT, BOX = "#1c2733", "rgba(246, 249, 252, 0.6)"
