"""Types of the compiled part. Its docstrings are the documentation: help(utm_fusion.records)."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, Optional, Union

Source = Union[str, PathLike[str], bytes]
Editions = Union[str, Sequence[str]]
File = Union[str, PathLike[str]]

__version__: str

class Error(Exception): ...
class InputWarning(UserWarning): ...

class Records(Iterator[dict[str, Any]]):
    @property
    def faults(self) -> dict[str, int]: ...
    def __iter__(self) -> Records: ...
    def __next__(self) -> dict[str, Any]: ...

class Table:
    @property
    def columns(self) -> list[str]: ...
    @property
    def unread(self) -> Optional[Table]: ...
    @property
    def faults(self) -> dict[str, int]: ...
    @property
    def damage(self) -> Optional[str]: ...
    def __len__(self) -> int: ...
    def __arrow_c_schema__(self) -> object: ...
    def __arrow_c_stream__(self, requested_schema: Optional[object] = None) -> object: ...
    def to_pandas(self) -> Any: ...

def records(
    source: Source,
    *,
    cat: Optional[int] = None,
    edition: Optional[Editions] = None,
    untyped: bool = False,
    errors_only: bool = False,
    hex: bool = False,
) -> Records: ...
def table(
    source: Source,
    cat: int,
    *,
    columns: Optional[Sequence[str]] = None,
    edition: Optional[Editions] = None,
    untyped: bool = False,
    hex: bool = False,
) -> Table: ...
def plots(source: Source) -> Table: ...
def encode(
    records: Union[Mapping[str, Any], Iterable[Mapping[str, Any]]], *, edition: Optional[Editions] = None
) -> bytes: ...
def simulate(
    scenario: File, out: File, *, seed: int = 1, duration_s: Optional[float] = None
) -> dict[str, Path]: ...
def replay(
    source: Union[Source, Sequence[Source]],
    config: File,
    *,
    profile: Optional[Literal["operational", "reference"]] = None,
    at: Literal["lagged", "now"] = "lagged",
    date: Optional[str] = None,
    output: Optional[File] = None,
) -> Table: ...
def evaluate(
    output: File,
    truth: Union[File, Sequence[File]],
    *,
    labels: Optional[File] = None,
    capture: Union[File, Sequence[File], None] = None,
    config: Optional[File] = None,
    date: Optional[str] = None,
    integrity: bool = False,
    attacks: Optional[File] = None,
    alerts: Optional[File] = None,
    conflicts: Optional[File] = None,
    plot: Optional[File] = None,
) -> dict[str, Any]: ...
def main(arguments: Sequence[str]) -> int: ...
