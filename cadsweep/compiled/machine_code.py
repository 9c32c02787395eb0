"""Machine code that numba has made, in files that are loaded without numba.

Place in the flow: :mod:`cadsweep.compiled.kernels` asks for code that was kept, and has code kept that numba has just
compiled or read from its own cache.

Method. The object file that numba makes of a function, and keeps in its cache among pickles that only numba can read,
holds the function with plain arguments: of an array its address, shape and strides. ``llvmlite`` links such a file in
10 ms, and ``ctypes`` calls it, without the interpreter's lock. What a function needs from numba's runtime is memory for
arrays of its own: a dozen lines of LLVM's language. The rest that an object file asks for belongs to the function that
takes Python's objects; it is never called here, and gets an address that ends the process. Code that asks for anything
else is not kept, nor code with arguments other than numbers and arrays of them in the order of C.

A file is for one processor, one version of numba and one state of the source file, as numba's own are: other files are
not looked at, nor those that are not whole. Without a folder to write to, nothing is kept.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import logging
import os
import sys
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np

log = logging.getLogger(__name__)

Kind = str | tuple[Any, ...]
"""What a function is compiled for: a word for a number or an array (`kernels.kind_of`), a tuple for a tuple."""

FORMAT = 1
"""Changes where files of before cannot be read."""

_NUMBERS = {"f": ctypes.c_double, "i": ctypes.c_int64, "b": ctypes.c_bool}
_RESULTS = {"none": ctypes.c_void_p, "float64": ctypes.c_double, "int64": ctypes.c_int64, "bool": ctypes.c_bool}

# What Python's side of a function asks numba for: never called from here.
_NEVER = frozenset(
    {
        "NRT_adapt_ndarray_from_python",
        "NRT_adapt_ndarray_to_python_acqref",
        "numba_do_raise",
        "numba_gil_ensure",
        "numba_gil_release",
        "numba_runtime_build_excinfo_struct",
        "numba_unpickle",
    }
)

# An array of numba's begins with a record: uses, three pointers (to what ends it, its argument, the numbers), a size,
# another allocator. POINTER is `ptr`, or `i64*` before version 15 of LLVM.
_MEMORY = """
declare i64 @calloc(i64, i64)
declare void @free(i64)
declare void @abort()
define i64 @cadsweep_allocate(i64 %size, i32 %align) {
  %a = zext i32 %align to i64
  %beside = add i64 %a, 64
  %all = add i64 %size, %beside
  %record = call i64 @calloc(i64 1, i64 %all)
  %none = icmp eq i64 %record, 0
  br i1 %none, label %end, label %fill
fill:
  %behind = add i64 %record, %beside
  %rest = urem i64 %behind, %a
  %numbers = sub i64 %behind, %rest
  %uses = inttoptr i64 %record to POINTER
  store i64 1, POINTER %uses
  %at = add i64 %record, 24
  %place = inttoptr i64 %at to POINTER
  store i64 %numbers, POINTER %place
  %far = add i64 %record, 32
  %length = inttoptr i64 %far to POINTER
  store i64 %size, POINTER %length
  br label %end
end:
  ret i64 %record
}
define void @cadsweep_release(i64 %record) {
  call void @free(i64 %record)
  ret void
}
define void @cadsweep_never() {
  call void @abort()
  unreachable
}
"""
_OURS = {
    "NRT_MemInfo_alloc_aligned": "cadsweep_allocate",
    "NRT_MemInfo_alloc_safe_aligned": "cadsweep_allocate",
    "NRT_MemInfo_call_dtor": "cadsweep_release",
    "NRT_Free": "cadsweep_release",
}


def load(function: FunctionType, kinds: Kind) -> Callable[..., Any] | None:
    """What was kept for arguments of these kinds, as a function of them; None where there is nothing.

    Raises, when called,
    --------------------
    MemoryError
        There was no room for the arrays of the function itself.
    """
    if not _is_plain(kinds):
        return None
    found = _read(function, _file_name(function, kinds))
    return None if found is None else _Native(*found, kinds)


def keep(function: FunctionType, kinds: Kind, dispatcher: Any) -> None:
    """Keep the code that numba has for arguments of these kinds, where it can be called without numba."""
    if not _is_plain(kinds):
        return
    name = _file_name(function, kinds)
    found = None if _read(function, name) else _compiled(dispatcher, kinds)
    if found is None:
        return
    rest = json.dumps(found[0]).encode() + b"\n" + found[1]
    for folder in _folders(function):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(_digest(rest) + b"\n" + rest)  # half of it, or of two, is no whole file
        except OSError as error:
            log.debug("compiled code is not kept in %s: %s", folder, error)
            continue
        return


def _read(function: FunctionType, name: str) -> tuple[dict[str, Any], bytes] | None:
    """How a function is called, and its code, from the first file that is whole."""
    for folder in _folders(function):
        try:
            digest, _, rest = (folder / name).read_bytes().partition(b"\n")
        except OSError:
            continue
        if digest == _digest(rest):
            head, _, code = rest.partition(b"\n")
            return json.loads(head), code
    return None


def _digest(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=12).hexdigest().encode()


def _compiled(dispatcher: Any, kinds: Kind) -> tuple[dict[str, Any], bytes] | None:
    """The object file in numba's cache, and how its function is called; None where only numba can call it."""
    import llvmlite.binding as llvm
    from numba.core.registry import cpu_target

    signatures = [s for s in dispatcher.overloads if _kind_of_type(s) == kinds]
    if not signatures:
        return None
    try:
        stored = dispatcher._cache
        data = stored._cache_file.load(stored._index_key(signatures[0], cpu_target.target_context.codegen()))
        if data is None:
            return None  # numba could not write its cache
        (_, form, (code, bitcode)), description, _, signature, *_ = data
    except (AttributeError, TypeError, ValueError) as error:
        log.debug("this version of numba keeps its code in another way: %s", error)
        return None
    module = llvm.parse_bitcode(bitcode)
    declared = [*module.functions, *module.global_variables]
    needs = sorted(one.name for one in declared if one.is_declaration and not one.name.startswith("llvm."))
    known = all(name in _OURS or name in _NEVER or llvm.address_of_symbol(name) is not None for name in needs)
    if form != "object" or not known or _result(str(signature.return_type)) is None:
        return None
    return {"symbol": description.llvm_func_name, "returns": str(signature.return_type), "needs": needs}, code


class _Native:
    """A function in machine code: its arguments become what numba's calling convention asks for."""

    def __init__(self, head: dict[str, Any], code: bytes, kinds: Kind) -> None:
        import llvmlite.binding as llvm

        engine = _engine()
        for name in head["needs"]:
            if llvm.address_of_symbol(name) is None:
                llvm.add_symbol(name, engine.get_function_address(_OURS.get(name, "cadsweep_never")))
        engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        engine.finalize_object()
        types = [ctypes.c_void_p, ctypes.c_void_p, *_argument_types(kinds)]
        self._call = ctypes.CFUNCTYPE(ctypes.c_int32, *types)(engine.get_function_address(head["symbol"]))
        self._result = _result(head["returns"])
        self._returns_nothing = head["returns"] == "none"

    def __call__(self, *args: Any) -> Any:
        given: list[Any] = []
        _lay_out(args, given)
        result, failure = self._result(), ctypes.c_void_p()  # type: ignore[misc]
        if self._call(ctypes.addressof(result), ctypes.addressof(failure), *given) not in (0, -2):
            raise MemoryError("a compiled loop found no room for its arrays")
        if self._returns_nothing:
            return None
        return tuple(result) if isinstance(result, ctypes.Array) else result.value


def _argument_types(kind: Kind) -> list[Any]:
    """Of an array: two owners, how many numbers, bytes of one, address, shape, strides."""
    if isinstance(kind, tuple):
        return [one for part in kind for one in _argument_types(part)]
    if kind in _NUMBERS:
        return [_NUMBERS[kind]]
    address, number = ctypes.c_void_p, ctypes.c_int64
    return [address, address, number, number, address] + [number] * (2 * int(kind.rpartition("C")[2]))


def _lay_out(values: tuple[Any, ...], given: list[Any]) -> None:
    """Append what the types of :func:`_argument_types` are filled with."""
    for value in values:
        if isinstance(value, np.ndarray):
            given += (0, 0, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides)
        elif isinstance(value, tuple):
            _lay_out(value, given)
        else:
            given.append(value)


def _result(returns: str) -> Any | None:
    """The type of what numba says that a function returns, or None for one that is not known here."""
    if returns.startswith("UniTuple(") and returns.endswith(")"):
        one, _, n = returns[9:-1].partition(" x ")
        return _RESULTS[one] * int(n) if one in ("float64", "int64") else None
    return _RESULTS.get(returns)


def _is_plain(kind: Kind) -> bool:
    """Whether machine code can be called with it: numbers, and arrays in the order of C."""
    if isinstance(kind, tuple):
        return all(map(_is_plain, kind))
    return kind in _NUMBERS or (kind[0] in "<|=" and "C" in kind)  # as numpy's words for types of numbers begin


def _kind_of_type(kind: Any) -> Kind:
    """The word of :func:`cadsweep.compiled.kernels.kind_of` for a type of numba's."""
    from numba import types

    if isinstance(kind, (tuple, types.BaseTuple)):
        return tuple(map(_kind_of_type, kind))
    from numba.np.numpy_support import as_dtype

    if isinstance(kind, types.Array):
        plain = kind.layout == "C" and kind.mutable and kind.aligned
        return f"{as_dtype(kind.dtype).str}{'C' if plain else 'A'}{kind.ndim}"
    return {types.float64: "f", types.int64: "i", types.boolean: "b"}.get(kind, str(kind))


@cache
def _engine() -> Any:
    """Where object files are linked; it knows the memory of arrays."""
    import llvmlite
    import llvmlite.binding as llvm

    if tuple(int(part) for part in llvmlite.__version__.split(".")[:2]) < (0, 45):
        llvm.initialize()
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    module = llvm.parse_assembly(_MEMORY.replace("POINTER", "ptr" if llvm.llvm_version_info[0] >= 15 else "i64*"))
    engine = llvm.create_mcjit_compiler(module, llvm.Target.from_default_triple().create_target_machine(opt=2))
    engine.finalize_object()
    return engine


@cache
def _machine() -> str:
    """The processor, and the versions of what compiles for it."""
    import llvmlite
    import llvmlite.binding as llvm

    # numba's own number would cost the import of numba, or of what reads the records of packages.
    numba = Path(str(find_spec("numba").origin)).with_name("_version.py").stat()  # type: ignore[union-attr]
    versions = (FORMAT, sys.version_info[:2], llvmlite.__version__, numba.st_mtime_ns, numba.st_size)
    return f"{versions} {llvm.get_host_cpu_name()} {llvm.get_host_cpu_features().flatten()}"


def _file_name(function: FunctionType, kinds: Kind) -> str:
    source = os.stat(function.__code__.co_filename)
    words = (_machine(), source.st_mtime_ns, source.st_size, function.__code__.co_firstlineno, kinds)
    digest = hashlib.blake2b(repr(words).encode(), digest_size=12).hexdigest()
    return f"{Path(function.__code__.co_filename).stem}.{function.__name__}.{digest}.kernel"


def _folders(function: FunctionType) -> list[Path]:
    """Where code may be kept: beside the module, or in the user's cache."""
    given = os.environ.get("NUMBA_CACHE_DIR")
    if given:
        return [Path(given) / "cadsweep"]
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return [Path(function.__code__.co_filename).parent / "__pycache__", home / "cadsweep" / "kernels"]
