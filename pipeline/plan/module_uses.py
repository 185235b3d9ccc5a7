"""What a module takes from other modules: which it imports, and which of their names it uses.

A name is written ``module:attribute.attribute``. The module may be relative and then begins with dots. For
``from riot import scores`` and ``scores.crs.best_trunk_pairs(…)`` the import is ``riot:scores`` and the use
``riot:scores.crs.best_trunk_pairs``. A local name that hides an import is no use of it. Imports under
``if TYPE_CHECKING`` do not count: no running code has them.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

_Function = ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda
_Comprehension = ast.ListComp | ast.SetComp | ast.DictComp | ast.GeneratorExp


@dataclass
class ModuleUses:
    """``imported`` and ``used`` names, and the ``bindings`` of the module: its own names of what it imports."""

    imported: set[str] = field(default_factory=set)
    used: set[str] = field(default_factory=set)
    bindings: dict[str, str] = field(default_factory=dict)


def uses_of(statement: ast.stmt, visible: Mapping[str, str]) -> set[str]:
    """What a top-level statement uses of the names that are ``visible`` in its module, and of what it imports."""
    uses = ModuleUses()
    scope = _Scope(hides=False)
    scope.read([statement], uses)
    scope.resolve(visible, uses)
    return uses.used


def module_uses(tree: ast.Module) -> ModuleUses:
    """The names that a module's code imports and uses.

    >>> uses = module_uses(ast.parse("from riot import scores\\nscores.crs.best_trunk_pairs()"))
    >>> uses.imported, uses.used
    ({'riot:scores'}, {'riot:scores.crs.best_trunk_pairs'})
    """
    uses = ModuleUses()
    module = _Scope(hides=False)
    module.read(tree.body, uses)
    uses.bindings = module.imports
    module.resolve({}, uses)
    return uses


@dataclass
class _Scope:
    """A module, function, class or comprehension: the names that it binds and loads, and the scopes inside it."""

    hides: bool
    """Whether a name that is bound here hides the import of that name. A class hides none from its methods."""
    bound: set[str] = field(default_factory=set)
    shared: set[str] = field(default_factory=set)
    """Names that are declared ``global`` or ``nonlocal``."""
    imports: dict[str, str] = field(default_factory=dict)
    loads: set[tuple[str, ...]] = field(default_factory=set)
    inner: list[_Scope] = field(default_factory=list)

    def resolve(self, outer: Mapping[str, str], uses: ModuleUses) -> None:
        """Add the uses of imported names, here and inside; ``outer``: the imported names that are visible around."""
        hidden = self.bound - self.shared if self.hides else set()
        visible = {name: target for name, target in outer.items() if name not in hidden} | self.imports
        for name, *attributes in self.loads:
            if name in visible:
                uses.used.add(".".join([visible[name], *attributes]).replace(":.", ":"))
        for scope in self.inner:
            scope.resolve(visible, uses)

    def read(self, nodes: Iterable[ast.AST], uses: ModuleUses) -> None:
        """Collect what the nodes bind, load and import."""
        pending = list(nodes)
        while pending:
            node = pending.pop()
            match node:
                case ast.Name():
                    if isinstance(node.ctx, ast.Load):
                        self.loads.add((node.id,))
                    else:
                        self.bound.add(node.id)
                case ast.Attribute():
                    base, attributes = _chain(node)
                    if isinstance(base, ast.Name):
                        self.loads.add((base.id, *attributes))
                    else:
                        pending.append(base)
                case ast.Import() | ast.ImportFrom():
                    self._import(node, uses)
                case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.Lambda():
                    pending += self._function(node, uses)
                case ast.ClassDef():
                    self.bound.add(node.name)
                    pending += [*node.decorator_list, *node.bases, *node.keywords]
                    self._inside(node.body, uses, hides=False)
                case ast.ListComp() | ast.SetComp() | ast.DictComp() | ast.GeneratorExp():
                    pending += self._comprehension(node, uses)
                case ast.If() if is_type_checking(node.test):
                    pending += node.orelse
                case ast.Global() | ast.Nonlocal():
                    self.shared.update(node.names)
                case _:
                    if isinstance(node, ast.ExceptHandler | ast.MatchAs | ast.MatchStar) and node.name:
                        self.bound.add(node.name)
                    elif isinstance(node, ast.MatchMapping) and node.rest:
                        self.bound.add(node.rest)
                    pending += ast.iter_child_nodes(node)

    def _import(self, node: ast.Import | ast.ImportFrom, uses: ModuleUses) -> None:
        if isinstance(node, ast.Import):
            uses.imported.update(f"{alias.name}:" for alias in node.names)
            for alias in node.names:
                top = alias.name.partition(".")[0]
                self.imports[alias.asname or top] = f"{alias.name if alias.asname else top}:"
        else:
            module = "." * node.level + (node.module or "")
            uses.imported.update(f"{module}:{alias.name}" for alias in node.names)
            self.imports |= {alias.asname or alias.name: f"{module}:{alias.name}" for alias in node.names}

    def _function(self, node: _Function, uses: ModuleUses) -> list[ast.AST]:
        """Read the inside of a function; returns what belongs to the outside: defaults, annotations, decorators."""
        arguments = node.args
        named = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs, arguments.vararg, arguments.kwarg]
        outside = [argument.annotation for argument in named if argument is not None]
        outside += [*arguments.defaults, *arguments.kw_defaults]
        if not isinstance(node, ast.Lambda):
            self.bound.add(node.name)
            outside += [*node.decorator_list, node.returns]
        inside = self._inside([node.body] if isinstance(node, ast.Lambda) else node.body, uses, hides=True)
        inside.bound.update(argument.arg for argument in named if argument is not None)
        return [part for part in outside if part is not None]

    def _comprehension(self, node: _Comprehension, uses: ModuleUses) -> list[ast.AST]:
        """Read the inside of a comprehension; returns what belongs to the outside: the first iterable."""
        first = node.generators[0].iter
        values = [node.key, node.value] if isinstance(node, ast.DictComp) else [node.elt]
        inside = [child for generator in node.generators for child in ast.iter_child_nodes(generator)]
        self._inside([*values, *(child for child in inside if child is not first)], uses, hides=True)
        return [first]

    def _inside(self, nodes: Iterable[ast.AST], uses: ModuleUses, *, hides: bool) -> _Scope:
        scope = _Scope(hides)
        scope.read(nodes, uses)
        self.inner.append(scope)
        return scope


def is_type_checking(test: ast.expr) -> bool:
    """Whether a condition is ``TYPE_CHECKING``, so that what it guards never runs."""
    return (isinstance(test, ast.Name) and test.id == "TYPE_CHECKING") or (
        isinstance(test, ast.Attribute) and test.attr == "TYPE_CHECKING"
    )


def _chain(node: ast.Attribute) -> tuple[ast.expr, list[str]]:
    """``a.b.c`` as ``a`` and ``["b", "c"]``."""
    attributes: list[str] = []
    base: ast.expr = node
    while isinstance(base, ast.Attribute):
        attributes.insert(0, base.attr)
        base = base.value
    return base, attributes
