"""The module has the texts of its stubs, so that `help` and an editor show the same."""

import ast
import inspect
from pathlib import Path

import pytest

import vademecum
from vademecum import _native

STUBS = ast.parse(Path(vademecum.__file__).with_name("_native.pyi").read_text(encoding="utf-8"))
CLASSES = [node for node in STUBS.body if isinstance(node, ast.ClassDef) and node.name != "File"]


def words(text):
    return (text or "").split()


@pytest.mark.parametrize("stub", CLASSES, ids=lambda stub: stub.name)
def test_a_class_has_the_texts_of_its_stub(stub):
    kind = getattr(_native, stub.name)
    assert words(ast.get_docstring(stub)) and words(kind.__doc__) == words(ast.get_docstring(stub))
    methods = [node for node in stub.body if isinstance(node, ast.FunctionDef) and not node.name.startswith("__")]
    setters = [node for node in methods if any(isinstance(d, ast.Attribute) for d in node.decorator_list)]
    for method in methods:
        if method in setters:
            continue
        text, found = ast.get_docstring(method), getattr(kind, method.name)
        assert words(text) and words(found.__doc__) == words(text), f"{stub.name}.{method.name}"
        if callable(found):
            assert "..." not in str(inspect.signature(found)) and "Ellipsis" not in str(inspect.signature(found))


def test_every_public_method_has_a_text():
    kinds = [kind for kind in map(vademecum.__dict__.get, vademecum.__all__) if inspect.isclass(kind)]
    assert len(kinds) > 30
    for kind in kinds:
        assert words(kind.__doc__), kind
        for name, member in vars(kind).items():
            if not name.startswith("_") and (callable(member) or isinstance(member, property) or inspect.isgetsetdescriptor(member)):
                assert words(getattr(kind, name).__doc__), f"{kind.__name__}.{name}"
    for name in vademecum.__all__:
        assert words(getattr(vademecum, name).__doc__), name


def test_completion_shows_the_package_alone():
    assert dir(vademecum) == sorted([*vademecum.__all__, "__version__"])
