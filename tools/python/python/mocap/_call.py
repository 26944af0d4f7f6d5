"""Checks the arguments of public functions against their annotations. Errors name the argument and its expected
type."""

from __future__ import annotations

import difflib
import functools
import inspect
import numbers
import os
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from ._errors import OptionError, UnknownOptionError, WrongTypeError

P = ParamSpec("P")
R = TypeVar("R")

# The number of checked values of a list. The native module checks all values.
_LOOKED_AT = 64


def public(function: Callable[P, R]) -> Callable[P, R]:
    """Decorates a function so that it first checks its arguments."""
    check = checker(function)

    @functools.wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        check(args, kwargs)
        return function(*args, **kwargs)

    return checked


def checker(function: Callable[..., Any]) -> Callable[[tuple[Any, ...], Mapping[str, Any]], None]:
    """Makes a checker of a function's arguments. The annotations are read at the first call. Python itself reports
    missing arguments."""
    parameters = inspect.signature(function).parameters
    takes_any = any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters.values())
    by_position = [name for name, of in parameters.items() if of.kind is of.POSITIONAL_OR_KEYWORD]
    others = [name for name, of in parameters.items() if of.kind is of.VAR_POSITIONAL]

    @functools.cache
    def hints() -> dict[str, Any]:
        known = get_type_hints(function)
        return {name: known[name] for name in parameters if name in known and not _is_array(known[name])}

    def check(args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> None:
        for name in kwargs:
            if name not in parameters and not takes_any:
                raise unknown_option(name, options_of(inspect.signature(function)))
        checked = hints()
        names = [*by_position, *others * (len(args) - len(by_position))]
        for name, value in (*zip(names, args), *kwargs.items()):
            if name in checked and not fits(value, checked[name]):
                raise refusal(name, value, checked[name])

    return check


def _is_array(hint: Any) -> bool:
    """Whether an annotation is a type of NumPy. The function itself checks shapes and numbers."""
    parts = (hint, *get_args(hint))
    return any(str(getattr(part, "__module__", "")).startswith("numpy") for part in parts)


def options_of(signature: inspect.Signature) -> list[str]:
    """The names of a function's optional arguments."""
    parameters = signature.parameters.values()
    return [of.name for of in parameters if of.kind is of.KEYWORD_ONLY or of.default is not of.empty]


def unknown_option(name: str, options: Iterable[str]) -> UnknownOptionError:
    """The error of an unknown option. Suggests the nearest name, or lists all names."""
    options = list(options)
    near = nearest(name, options)
    if near is not None:
        return UnknownOptionError(f"there is no option {name!r}; did you mean {near!r}?")
    return UnknownOptionError(f"there is no option {name!r}; the options are {', '.join(options)}")


def nearest(word: str, words: Iterable[str]) -> str | None:
    """The most similar word, if a word is similar enough."""
    plain = {known.replace("-", "_").lower(): known for known in words}
    found = difflib.get_close_matches(word.replace("-", "_").lower(), plain, n=1, cutoff=0.6)
    return plain[found[0]] if found else None


def refusal(name: str, value: object, hint: Any) -> OptionError:
    """The error of an argument with a wrong type or value."""
    message = f"{name} must be {described(hint)}, got {shown(value)}"
    if not isinstance(value, str):
        return WrongTypeError(message)
    near = nearest(value, [word for word in words_of(hint) if isinstance(word, str)])
    # A text that is not a word of the option still has the type ``str``.
    kind = OptionError if words_of(hint) else WrongTypeError
    return kind(message if near is None else f"{message}; did you mean {near!r}?")


def shown(value: object) -> str:
    """A short text of a value for a message, with the type if the text does not show it."""
    text = repr(value)
    text = text if len(text) <= 60 else text[:57] + "..."
    is_plain = value is None or isinstance(value, (str, bytes, bool, int, float, list, tuple, dict))
    return text if is_plain else f"{text} ({type(value).__name__})"


def words_of(hint: Any) -> list[object]:
    """The literal words of an annotation."""
    if get_origin(hint) is Literal:
        return list(get_args(hint))
    return [word for part in get_args(hint) for word in words_of(part)] if _is_union(hint) else []


def _is_union(hint: Any) -> bool:
    return get_origin(hint) in (Union, types.UnionType)


def fits(value: Any, hint: Any) -> bool:
    """Whether a value has the type of an annotation."""
    origin, parts = get_origin(hint), get_args(hint)
    if hint is Any:
        return True
    if hint is None or hint is type(None):
        return value is None
    if _is_union(hint):
        return any(fits(value, part) for part in parts)
    if origin is Literal:
        return any(type(value) is type(word) and value == word for word in parts)
    if hint is bool:
        return isinstance(value, (bool, np.bool_))
    if hint is int:
        return isinstance(value, numbers.Integral) and not isinstance(value, bool)
    if hint is float:
        is_array = isinstance(value, np.ndarray) and value.shape == () and value.dtype.kind in "iuf"
        return is_array or (isinstance(value, numbers.Real) and not isinstance(value, bool))
    if origin is tuple:
        items: Any = list(value) if isinstance(value, (tuple, list, np.ndarray)) else None
        return items is not None and len(items) == len(parts) and all(map(fits, items, parts))
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return isinstance(value, Mapping) and all(
            fits(key, parts[0]) and fits(item, parts[1]) for key, item in value.items()
        )
    if origin in _LISTS:
        if isinstance(value, (str, bytes)) or not isinstance(value, (Iterable, np.ndarray)):
            return False
        if origin is not Iterable and not isinstance(value, (Sequence, np.ndarray)):
            return False
        # Do not check an iterator, because the check would exhaust it.
        items = value if isinstance(value, (Sequence, np.ndarray)) else ()
        return all(fits(item, parts[0]) for item in items[:_LOOKED_AT])
    if isinstance(origin, type):
        return isinstance(value, origin)
    # The functions themselves check arrays and all other types.
    return not isinstance(hint, type) or isinstance(value, hint)


_LISTS: tuple[object, ...] = (list, Sequence, Iterable)


def described(hint: Any) -> str:
    """An annotation as text."""
    parts = _parts(hint)
    words = [repr(word) for part in parts for word in words_of(part)]
    kinds = [_kind(part) for part in parts if not words_of(part)]
    texts = [*words, *dict.fromkeys(kinds)]
    if len(texts) < 2:
        return "".join(texts)
    return f"{', '.join(texts[:-1])} or {texts[-1]}"


def _parts(hint: Any) -> list[Any]:
    """The types of a union, without ``None``, and without ``str`` if it stands for a path."""
    parts = [part for part in (get_args(hint) if _is_union(hint) else [hint]) if part is not type(None)]
    has_path = any(get_origin(part) is os.PathLike for part in parts)
    return [part for part in parts if not (has_path and part is str)]


def _kind(hint: Any) -> str:
    origin, parts = get_origin(hint), get_args(hint)
    if hint in _KINDS:
        return _KINDS[hint]
    if origin is os.PathLike:
        return "a path"
    if origin is tuple:
        return f"a pair of {_kind_of_many(parts[0])}" if len(parts) == 2 else f"{len(parts)} {_kind_of_many(parts[0])}"
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return "a dictionary"
    if origin in _LISTS:
        return f"a list of {_kind_of_many(parts[0])}"
    name: str = getattr(hint, "__name__", str(hint))
    return f"a {name}"


def _kind_of_many(hint: Any) -> str:
    plain = {float: "numbers", int: "whole numbers", str: "names"}
    if words_of(hint):
        return described(hint)
    parts = _parts(hint)
    return " or ".join(plain.get(part, _plural(_kind(part)[2:])) for part in parts)


def _plural(word: str) -> str:
    return f"{word[:-1]}ies" if word.endswith("y") else f"{word}s"


_KINDS: Mapping[Any, str] = {
    bool: "True or False",
    int: "a whole number",
    float: "a number",
    str: "a string",
    bytes: "bytes",
}
