# SPDX-License-Identifier: Apache-2.0
"""The package: its help, its types, its one exception."""
import ast
import inspect
import pathlib
import pickle

import pytest

import panelcal
from panelcal import _core

FOLDER = pathlib.Path(panelcal.__file__).parent


def members_of(body):
    names = {node.name for node in body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    return names | {node.target.id for node in body if isinstance(node, ast.AnnAssign)}


def is_public(name):
    return not name.startswith("_") or name in ("_row", "__version__")


def test_the_stub_names_what_the_extension_has():
    assert (FOLDER / "py.typed").exists()
    tree = ast.parse((FOLDER / "_core.pyi").read_text())
    assert {name for name in members_of(tree.body)} == set(filter(is_public, vars(_core)))
    for node in tree.body:
        if not isinstance(node, ast.ClassDef):
            continue
        stated = {name for name in members_of(node.body) if is_public(name)}
        assert stated == set(filter(is_public, vars(getattr(_core, node.name)))), node.name


def test_everything_has_help_that_teaches():
    for name in panelcal.__all__:
        thing = getattr(panelcal, name)
        if name == "__version__":
            continue
        text = inspect.getdoc(thing)
        assert text and len(text.splitlines()[0]) > 20, name
        if inspect.isfunction(thing):
            signature = inspect.signature(thing)
            assert "Parameters\n----------" in text, name
            missing = [one for one in signature.parameters if one not in text]
            assert not missing, (name, missing)
            assert all(one.annotation is not inspect.Parameter.empty
                       for one in signature.parameters.values()), name
        elif inspect.isclass(thing) and thing.__module__ == "panelcal" and name not in ("Error",):
            assert hasattr(thing, "__dataclass_fields__") or "Notes\n-----" in text, name
        assert name in panelcal.__doc__ or name[0].isupper() or name in (
            "parse_machine", "read_image", "write_png", "located_row"), name


def test_classes_say_whether_threads_may_share_them():
    for name in ("CameraMapping", "Detection", "Image", "Machine", "PanelFit", "Program", "Samples",
                 "Surface", "Target"):
        text = inspect.getdoc(getattr(panelcal, name))
        assert "hread" in text, name


def test_examples_of_the_help_are_true():
    import doctest
    import numpy
    result = doctest.testmod(panelcal, extraglobs={"panelcal": panelcal, "numpy": numpy})
    assert result.attempted >= 6 and result.failed == 0


def test_an_error_survives_pickling():
    with pytest.raises(panelcal.Error) as error:
        panelcal.Target("disk", size_px=3)
    again = pickle.loads(pickle.dumps(error.value))
    for key in ("code", "file", "line", "column", "what", "expected", "log"):
        assert getattr(again, key) == getattr(error.value, key)
    assert str(again) == str(error.value) == error.value.log[0]["text"]
