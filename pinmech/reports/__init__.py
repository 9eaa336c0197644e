"""The papers' numbers from the URDF models: :func:`reproduce` writes tables and figures.

Beside :mod:`pinmech.show`, above the analyses; matplotlib is imported only when figures are drawn.
"""

from __future__ import annotations

from pinmech.reports.papertable import PaperTable
from pinmech.reports.reproduction import PAPERS, Progress, Reproduction, reproduce
from pinmech.reports.tables import read_verdicts
from pinmech.reports.verdict import MEANING, VERDICTS, Item, Verdict, worse

__all__ = [
    "MEANING",
    "PAPERS",
    "VERDICTS",
    "Item",
    "PaperTable",
    "Progress",
    "Reproduction",
    "Verdict",
    "read_verdicts",
    "reproduce",
    "worse",
]
