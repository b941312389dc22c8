"""Exceptions of the package. Each is also the built-in exception that a caller would expect."""

from __future__ import annotations

from typing import Any

__all__ = [
    "ClusterError",
    "MissingExtraError",
    "OpenBoundaryWarning",
    "OutOfMemoryError",
    "ParameterError",
    "ParameterTypeError",
    "PoorFitWarning",
    "SingularError",
    "StudyInterrupted",
    "VibroimpactError",
]


class VibroimpactError(Exception):
    """Base of all exceptions that this package raises deliberately."""

    #: Exit status of the command.
    status = 2


class ParameterError(VibroimpactError, ValueError):
    """A parameter has a value that is not allowed; nothing was computed."""


class ParameterTypeError(VibroimpactError, TypeError):
    """A parameter has the wrong type; nothing was computed."""


class SingularError(VibroimpactError, ArithmeticError):
    """The equations have no unique, finite solution for these (allowed) parameters.

    The attribute `result` is the part of a simulation of a structure before this point, or None.
    """

    result: Any = None


class OpenBoundaryWarning(UserWarning):
    """`Zone.contains` or `Zone.count` was asked about points that an open boundary leaves undecided."""


class PoorFitWarning(UserWarning):
    """A fit deviates from the records by more than their noise, or these contradict the known values.

    The errors of the fit are then not valid. `Identification.doubts` lists the reasons.
    """


class MissingExtraError(VibroimpactError, ImportError):
    """An optional library is missing."""

    status = 1


class OutOfMemoryError(VibroimpactError, MemoryError):
    """A case needs more memory or stack than is available; nothing was computed."""

    status = 1


class ClusterError(VibroimpactError, ConnectionError):
    """The connection to the scheduler of a cluster is lost, or its workers cannot compute.

    Finished chunks are kept.
    """

    status = 1


class StudyInterrupted(KeyboardInterrupt):
    """Ctrl-C stopped a study; the attribute `result` is the part that was finished.

    Attributes
    ----------
    result
        The finished part, of the class that the function returns.
    """

    def __init__(self, result: Any) -> None:
        super().__init__(
            "stopped; the attribute `result` of this exception is the part that was finished"
        )
        self.result = result


# tracebacks show the names that users import
for _name in __all__:
    globals()[_name].__module__ = "vibroimpact"
