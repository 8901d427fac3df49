"""ASTERIX captures as dicts and columns, and the commands of utm-fusion as functions: simulate, replay, evaluate."""

from ._native import (
    Error,
    InputWarning,
    Records,
    Table,
    __version__,
    encode,
    evaluate,
    plots,
    records,
    replay,
    simulate,
    table,
)

__all__ = [
    "Error",
    "InputWarning",
    "Records",
    "Table",
    "__version__",
    "encode",
    "evaluate",
    "plots",
    "records",
    "replay",
    "simulate",
    "table",
]
