"""How kernels are compiled: Numba's pipeline, made cheap for many small functions that end up in one large one.

Numba optimises every function, with all that it calls, and generates its machine code before the caller gets to see
it; a function five calls deep is then compiled five times. Here a kernel that is called by a kernel is only lowered,
and inlined; the kernel called from Python is optimised as a whole, once. So a large kernel should have one call site.
"""

# Numba is typed in part only.
# mypy: disable-error-code="attr-defined, misc, no-untyped-call, override"
from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import Any, Final

from llvmlite import binding
from numba.core import config, ir, types
from numba.core.codegen import JITCodeLibrary, get_host_cpu_features
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, PassManager, register_pass
from numba.core.errors import TypingError
from numba.core.ir_utils import build_definitions
from numba.core.lowering import Lower
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import NativeLowering, NopythonRewrites, NopythonTypeInference
from numba.core.untyped_passes import FixupArgs, InlineClosureLikes, InlineInlinables, WithLifting

from ssmash_gym.dynamics import lowering as lowering  # registers lanes with Numba

OPTIONS: Final = {"nopython": True, "nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
INNER_OPTIONS: Final = {"no_cpython_wrapper": True, "forceinline": True}
ALLOCATORS: Final = frozenset(
    ("array", "copy", "empty", "empty_like", "full", "full_like", "ones", "ones_like", "zeros", "zeros_like")
)
CACHE_LINE: Final = 64  # bytes, and those of the widest lane
NEEDLESS: Final = (WithLifting, InlineClosureLikes, InlineInlinables, NopythonRewrites)  # nothing for them in kernels


def has_wide_vectors() -> bool:
    """Whether the processor that kernels are compiled for works on 8 doubles in one instruction (AVX-512)."""
    features = get_host_cpu_features() if config.CPU_FEATURES is None else config.CPU_FEATURES
    return "+avx512f" in features.split(",")


@register_pass(mutates_CFG=False, analysis_only=False)
class _FoldEnums(FunctionPass):
    """Replace ``Rows.NAME``, for a global `IntEnum` class, by its integer.

    Rows are plain integers then: no enum class is typed again and again, ``base + Rows.NAME`` is a constant for
    LLVM, and a kernel that gets a row as an argument is compiled once, not once for each enum class.
    """

    _name = "ssmash_fold_enums"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        blocks = state.func_ir.blocks
        classes = {
            assign.target.name: assign.value.value
            for block in blocks.values()
            for assign in block.find_insts(ir.Assign)
            if isinstance(assign.value, ir.Global | ir.FreeVar) and _is_rows(assign.value.value)
        }
        if not classes:
            return False
        for block in blocks.values():
            for assign in block.find_insts(ir.Assign):
                _fold(assign, classes)
        _drop_unused(blocks, classes)
        state.func_ir._definitions = build_definitions(blocks)
        return True


def _is_rows(value: Any) -> bool:
    return isinstance(value, type) and issubclass(value, IntEnum)


def _fold(assign: Any, classes: dict[str, type[IntEnum]]) -> None:
    value = assign.value
    if isinstance(value, ir.Expr) and value.op == "getattr" and value.value.name in classes:
        member = classes[value.value.name].__members__.get(value.attr)
        if member is not None:
            assign.value = ir.Const(int(member), value.loc)


def _drop_unused(blocks: Any, classes: dict[str, type[IntEnum]]) -> None:
    """Remove the assignments of enum classes that nothing reads any more."""
    statements = [statement for block in blocks.values() for statement in block.body]
    used = {
        variable.name
        for statement in statements
        for variable in statement.list_vars()
        if not (isinstance(statement, ir.Assign) and statement.target.name == variable.name)
    }
    for block in blocks.values():
        block.body = [
            statement
            for statement in block.body
            if not isinstance(statement, ir.Assign)
            or statement.target.name not in classes
            or statement.target.name in used
        ]


@register_pass(mutates_CFG=False, analysis_only=True)
class _RefuseArrays(FunctionPass):
    """A kernel compiled without reference counts must not hand out an array."""

    _name = "ssmash_refuse_arrays"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        if not state.flags.nrt and _holds_array(state.return_type):
            raise TypingError(f"kernel {state.func_id.func_name} returns an array; a kernel returns numbers")
        return False


def _holds_array(ty: Any) -> bool:
    return any(_holds_array(item) for item in ty) if isinstance(ty, types.BaseTuple) else isinstance(ty, types.Array)


class _AlignedLower(Lower):
    """Lowering of a function whose stack begins at a cache line: a lane kept on it does not straddle two."""

    def setup_function(self, fndesc: Any) -> None:
        super().setup_function(fndesc)
        self.function.attributes.add("nounwind")  # with no attribute in the set llvmlite leaves the alignment out
        self.function.attributes.alignstack = CACHE_LINE


@register_pass(mutates_CFG=True, analysis_only=False)
class _AlignedLowering(NativeLowering):
    _name = "ssmash_aligned_lowering"

    @property
    def lowering_class(self) -> type[Lower]:
        return _AlignedLower


class KernelCompiler(CompilerBase):
    """Numba's pipeline with rows of tables folded to integers and without the passes that kernels do not need."""

    def define_pipelines(self) -> list[PassManager]:
        """The one pipeline."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        replaced = {NativeLowering: _AlignedLowering}
        passes.passes = [(replaced.get(entry, entry), why) for entry, why in passes.passes if entry not in NEEDLESS]
        if self.state.func_ir is None:
            passes.add_pass_after(_FoldEnums, FixupArgs)
        passes.add_pass_after(_RefuseArrays, NopythonTypeInference)
        passes.finalize()
        return [passes]


class _InnerLibrary(JITCodeLibrary):
    """Code of a kernel for its callers: neither optimised nor made executable by itself."""

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        names = [variable.name for variable in self._final_module.global_variables]
        environments = [name for name in names if name.startswith("_ZN08NumbaEnv")]
        text = "".join(f'@"{name}" = common global i64 0\n' for name in environments)
        self._stand_in = binding.parse_assembly(text)  # Numba looks up the environment of each function
        self._codegen._add_module(self._stand_in)
        self._finalized = True


class _InnerCompiler(KernelCompiler):
    def define_pipelines(self) -> list[PassManager]:
        self.state.library = _InnerLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        return super().define_pipelines()


class KernelDispatcher(CPUDispatcher):
    """Versions of a kernel for Python, and beside them (`inner`) those for other kernels.

    Inner versions are inlined into their callers. There is one version for all integer arguments, whether their value
    is known or not. A kernel that makes no array is compiled without reference counts: counting the references of
    tables costs more than many a kernel.
    """

    def __init__(
        self,
        py_func: Callable[..., Any],
        locals: dict[str, Any] | None = None,
        targetoptions: dict[str, Any] | None = None,
        pipeline_class: type[CompilerBase] = KernelCompiler,
    ) -> None:
        """Take the arguments of Numba's dispatcher; only the function needs to be given."""
        counts = not ALLOCATORS.isdisjoint(py_func.__code__.co_names)
        options = {**OPTIONS, "_nrt": counts} if targetoptions is None else targetoptions
        super().__init__(py_func, locals or {}, options, pipeline_class)
        self.inner = CPUDispatcher(py_func, {}, {**options, **INNER_OPTIONS}, _InnerCompiler)

    def get_call_template(self, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        """Typing of a call by another kernel."""
        plain = {name: types.unliteral(ty) for name, ty in kws.items()}
        return self.inner.get_call_template(tuple(types.unliteral(ty) for ty in args), plain)

    def get_overload(self, sig: Any) -> Any:
        """Key of the version for another kernel."""
        return self.inner.get_overload(sig)
