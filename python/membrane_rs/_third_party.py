"""Third-party packages that nearly every module needs, imported in one order: see `_on_demand`."""

# ruff: noqa: F401 - imported to be loaded

from __future__ import annotations

import annotated_types
import numpy
import numpy.typing
import pydantic.dataclasses
import pydantic_core
import typing_extensions
from pydantic import (
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
)
