"""The papers' numbers from the URDF models: :func:`reproduce` writes tables and figures.

Beside :mod:`pinmech.show`, above the analyses; matplotlib is imported only when figures are drawn.
"""

from __future__ import annotations

from papers.papertable import PaperTable
from papers.reproduction import PAPERS, Progress, Reproduction, reproduce
from papers.tables import read_verdicts
from papers.verdict import MEANING, VERDICTS, Item, Verdict, worse

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
