"""Columns of numbers as an Arrow IPC stream: what pandas, polars and the page read without loss."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import pyarrow as pa
from numpy.typing import NDArray


def arrow_stream(columns: Mapping[str, NDArray[Any]], about: Mapping[str, Any]) -> bytes:
    """columns: name -> (N,) array; about: for the schema's metadata, under ``pa10d``."""
    table = pa.table({name: pa.array(values) for name, values in columns.items()})
    table = table.replace_schema_metadata({"pa10d": json.dumps(about)})
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, table.schema) as writer:
        writer.write_table(table)
    return bytes(sink.getvalue())
