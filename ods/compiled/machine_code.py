"""Kernels as machine code: linked and called without numba and without a compiler.

`ods compile` keeps the object code that numba made, in one file for each package (object_code.py). Here LLVM's linker,
which llvmlite brings, links it to the same C functions of numba as numba itself would: numba's compiled modules are
loaded for that, but nothing of the compiler, which costs more memory and time than all kernels together.
"""

import builtins
import ctypes
import importlib.util
import inspect
import logging
import pickle
import sys
from collections.abc import Callable, Iterator
from functools import cache, update_wrapper
from importlib.machinery import ExtensionFileLoader
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from ods.compiled import cache_folder
from ods.compiled.type_names import name_of_value, shape_of_values

log = logging.getLogger(__name__)

FILE = "machine-code"
_LOADED = "_dynfunc", "_helperlib", "core.runtime._nrt_python"
"""Compiled modules of numba."""


class Variant(NamedTuple):
    """A kernel compiled for one choice of argument types."""

    types: tuple[str, ...]
    symbol: str
    """Of the function that Python can call."""
    environment: str
    """Symbol of its own constants."""
    constants: dict[str, list[Any]]
    """Python objects that it, and those it calls, use, by symbol."""
    object_code: bytes
    """A relocatable ELF file."""


class MachineCode(NamedTuple):
    """What the file of a package holds."""

    made_for: tuple[str, ...]
    jobs: frozenset[str]
    """Digests of the settings for which nothing is missing."""
    kernels: dict[str, tuple[Variant, ...]]


def load(package: Path) -> MachineCode | None:
    """Return the machine code of the package's sources as they are, made for this computer; None where there is none.

    Only files that nobody else could have written are opened.
    """
    for folder in cache_folder.folders(package):
        file = folder / FILE
        if not cache_folder.is_safe(file):
            continue
        try:
            code = pickle.loads(file.read_bytes())
        except (OSError, pickle.UnpicklingError, EOFError, AttributeError, ImportError):
            continue
        if isinstance(code, MachineCode) and code.made_for == this_computer():
            return code
    return None


@cache
def this_computer() -> tuple[str, ...]:
    """Return what machine code depends on besides its sources: versions, and the processor.

    Python's is that of its binary interface, without the date of its build: a security update of the distribution makes
    nothing compile on board.
    """
    from llvmlite import binding

    versions = [f"{name} {version(name)}" for name in ("numba", "llvmlite", "numpy")]
    python = f"{sys.implementation.cache_tag}{sys.abiflags} {sys.hexversion:x}"
    return python, *versions, binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten()


class LinkedCode:
    """The kernels of a package, in memory and ready to be called."""

    def __init__(self, code: MachineCode) -> None:
        self._kernels = code.kernels
        self._numba = _numba_without_compiler()
        self._engine = _engine()
        self._environments: dict[str, Any] = {}
        for variant in self._variants():
            self._engine.add_object_file(_object_file(variant.object_code))
        self._engine.finalize_object()
        self._kernels = {  # LLVM has copies of the object code
            name: tuple(variant._replace(object_code=b"") for variant in variants)
            for name, variants in code.kernels.items()
        }
        for variant in self._variants():
            self._place(variant.constants)

    def kernel(self, function: Callable[..., Any], by_numba: Callable[[], Any]) -> "Kernel":
        """Return the kernel made of `function`; `by_numba` compiles it for types that nobody thought of."""
        name = f"{function.__module__}.{function.__qualname__}"
        variants = {variant.types: self._callable(function, variant) for variant in self._kernels.get(name, ())}
        return Kernel(function, variants, by_numba)

    def _variants(self) -> Iterator[Variant]:
        for variants in self._kernels.values():
            yield from variants

    def _place(self, constants: dict[str, list[Any]]) -> None:
        for symbol, values in constants.items():
            if symbol not in self._environments:
                environment = self._numba["_dynfunc"].Environment({})
                environment.consts[:] = values
                self._environments[symbol] = environment
                address = self._engine.get_global_value_address(symbol)
                ctypes.c_void_p.from_address(address).value = id(environment)

    def _callable(self, function: Callable[..., Any], variant: Variant) -> Callable[..., Any]:
        made: Callable[..., Any] = self._numba["_dynfunc"].make_function(
            sys.modules[function.__module__],
            function.__name__,
            function.__doc__ or "",
            self._engine.get_function_address(variant.symbol),
            self._environments[variant.environment],
            (self,),
        )
        return made


class Kernel:
    """A kernel as machine code: called like the function it was made of."""

    def __init__(
        self,
        function: Callable[..., Any],
        variants: dict[tuple[str, ...], Callable[..., Any]],
        by_numba: Callable[[], Any],
    ) -> None:
        update_wrapper(self, function)
        self._variants = variants
        self._by_numba = cache(by_numba)
        self._chosen: dict[tuple[Any, ...], Callable[..., Any]] = {}

    def __call__(self, *args: Any, **named: Any) -> Any:
        """Call the variant for these arguments."""
        if named:
            args = inspect.signature(self.__wrapped__).bind(*args, **named).args  # type: ignore[attr-defined]
        shape = shape_of_values(args)
        chosen = self._chosen.get(shape) or self._choose(shape, args)
        return chosen(*args)

    def _choose(self, shape: tuple[Any, ...], args: tuple[Any, ...]) -> Callable[..., Any]:
        types = tuple(map(name_of_value, args))
        if types not in self._variants:
            name = self.__wrapped__.__qualname__  # type: ignore[attr-defined]
            log.warning("%s is compiled: `ods compile` has not met it with (%s)", name, ", ".join(types))
            self._variants[types] = self.dispatcher()
        self._chosen[shape] = self._variants[types]
        return self._chosen[shape]

    @property
    def signatures(self) -> list[tuple[str, ...]]:
        """Types of arguments that it is compiled for, as numba's dispatchers tell theirs."""
        return list(self._variants)

    def dispatcher(self) -> Any:
        """Return the kernel as numba compiles it."""
        _teach_numba()
        return self._by_numba()


@cache
def _teach_numba() -> None:
    """Let kernels that numba compiles call those that are machine code: it compiles them into the caller."""
    from numba.extending import typeof_impl

    @typeof_impl.register(Kernel)
    def type_of(kernel: Kernel, context: Any) -> Any:
        return typeof_impl(kernel.dispatcher(), context)


@cache
def _engine() -> Any:
    from llvmlite import binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    machine = binding.Target.from_default_triple().create_target_machine(jit=True)
    return binding.create_mcjit_compiler(binding.parse_assembly(""), machine)


def _object_file(object_code: bytes) -> Any:
    from llvmlite import binding

    return binding.ObjectFileRef.from_data(object_code)


@cache
def _numba_without_compiler() -> dict[str, ModuleType]:
    """Load the compiled modules of numba, and tell the linker where their functions are, by numba's names."""
    from llvmlite import binding

    modules = {name: _extension(name) for name in _LOADED}
    modules["core.runtime._nrt_python"].memsys_use_cpython_allocator()
    symbols = {"_Py_NoneStruct": id(None), "numba_unpickle": ctypes.cast(_UNPICKLE, ctypes.c_void_p).value}
    for name, kind in vars(builtins).items():
        if isinstance(kind, type) and issubclass(kind, BaseException):
            symbols[f"PyExc_{name}"] = id(kind)
    for module in ("_helperlib", "_dynfunc"):
        for name, address in modules[module].c_helpers.items():
            symbols.setdefault(f"numba_{name}", address)
    for name, address in modules["core.runtime._nrt_python"].c_helpers.items():
        symbols[name if name.startswith("_") else f"NRT_{name}"] = address
    for symbol, address in symbols.items():
        binding.add_symbol(symbol, address)
    return modules


def _extension(name: str) -> ModuleType:
    """Load a compiled module of numba without the package that it is in."""
    found = importlib.util.find_spec("numba")
    if found is None or found.origin is None:
        raise ModuleNotFoundError("No module named 'numba'", name="numba")
    file = next(Path(found.origin).parent.glob(f"{name.replace('.', '/')}.*.so"))
    spec = importlib.util.spec_from_loader(f"numba.{name}", ExtensionFileLoader(f"numba.{name}", str(file)))
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    assert spec.loader is not None
    spec.loader.exec_module(module)
    return module


def _unpickle(data: int, size: int, _digest: int) -> Any:
    """Return a Python object that machine code holds as bytes: a class of records, an exception, that of arrays."""
    found = _UNPICKLED.get(data)
    if found is None:
        found = _UNPICKLED[data] = pickle.loads(ctypes.string_at(data, size))
    return found


_UNPICKLED: dict[int, Any] = {}
"""By address: machine code stays where it was linked, and asks for the class of each array that it returns."""
_UNPICKLE = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)(_unpickle)
"""In place of numba's own, which imports the compiler."""
