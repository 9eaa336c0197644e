"""Numbers and tables that nobody can change, and that stay so when they are pickled or copied."""

from __future__ import annotations

from typing import Any, NoReturn, TypeVar

import numpy as np

Array = np.ndarray
K = TypeVar("K")
V = TypeVar("V")


def frozen(values: object, dtype: object = None) -> Array:
    """A read-only copy of an array (units as given); itself when it is one already.

    It is a view of immutable bytes, so ``setflags(write=True)`` fails: a flag alone, anybody
    could take back.
    """
    array = np.asarray(values, dtype=dtype)  # type: ignore[call-overload]
    if isinstance(array.base, bytes):
        return array
    return _from_bytes(array.tobytes(), array.dtype.str, array.shape)


def _from_bytes(buffer: bytes, dtype: str, shape: tuple[int, ...]) -> Array:
    return np.ndarray(shape, np.dtype(dtype), buffer)


class Table(dict[K, V]):
    """A dictionary that cannot be changed; unlike ``MappingProxyType`` it pickles."""

    def _refuse(self, *_: object, **__: object) -> NoReturn:
        raise TypeError("this table is read-only; dict(table) gives a copy to work with")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self),)


class _Travelling:
    """Stands for a read-only array in a pickle, and arrives as the array."""

    def __init__(self, array: Array) -> None:
        self.array = array

    def __reduce__(self) -> tuple[Any, ...]:
        return _from_bytes, (self.array.tobytes(), self.array.dtype.str, self.array.shape)


class Sealed:
    """For frozen dataclasses: their read-only arrays are read-only again after pickle and copy."""

    def __getstate__(self) -> dict[str, Any]:
        return {name: _packed(value) for name, value in self.__dict__.items()}

    def __copy__(self: V) -> V:
        return self


def _packed(value: Any) -> Any:
    if isinstance(value, np.ndarray) and not value.flags.writeable:
        return _Travelling(value)
    if isinstance(value, Table):
        return Table({key: _packed(entry) for key, entry in value.items()})
    return value
