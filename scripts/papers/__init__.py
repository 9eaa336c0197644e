"""The papers' numbers from the URDF models: :func:`reproduce` writes tables and figures.

For each paper ``<name>.py`` holds its items as data, ``<name>_*.py`` what they ask of the model,
``<name>_figures.py`` its pictures; matplotlib is imported only when pictures are drawn.
"""

from __future__ import annotations

from papers.items import Paper
from papers.reproduction import PAPERS, Progress, Reproduction, reproduce
from papers.tables import PaperTable, read_verdicts
from papers.verdict import MEANING, VERDICTS, Row, Verdict, worse

__all__ = [
    "MEANING",
    "PAPERS",
    "VERDICTS",
    "Paper",
    "PaperTable",
    "Progress",
    "Reproduction",
    "Row",
    "Verdict",
    "read_verdicts",
    "reproduce",
    "worse",
]
