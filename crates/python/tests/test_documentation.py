"""Every public name has a numpydoc docstring with an example, whose parameters are those of the signature."""

import inspect

import pytest

import luenberger as lg

PUBLIC = [name for name in lg.__all__ if name != "__version__"]


@pytest.mark.parametrize("name", PUBLIC)
def test_a_name_is_documented(name):
    entry = getattr(lg, name)
    text = inspect.getdoc(entry)
    assert text and text[0].isupper() and text.split("\n")[0].endswith("."), text
    if inspect.isclass(entry) and issubclass(entry, Exception):
        return
    assert "Examples\n--------\n" in text and ">>> " in text
    if inspect.isfunction(entry):
        parameters = inspect.signature(entry).parameters
        for parameter in parameters.values():
            if parameter.kind is not parameter.VAR_POSITIONAL:
                assert parameter.name in text.split("Returns\n")[0], parameter.name
        assert ("Parameters\n----------\n" in text) == bool(parameters) and "Returns\n-------\n" in text


@pytest.mark.parametrize("name", [name for name in PUBLIC if inspect.isclass(getattr(lg, name))])
def test_public_members_are_documented(name):
    for member, value in vars(getattr(lg, name)).items():
        if not member.startswith("_") and (inspect.isfunction(value) or isinstance(value, property)):
            assert inspect.getdoc(value), f"{name}.{member}"


def test_exceptions_are_those_of_their_neighbours():
    import numpy as np

    errors = [getattr(lg, name) for name in PUBLIC if name in vars(lg.errors) and inspect.isclass(getattr(lg, name))]
    assert all(issubclass(error, lg.LuenbergerError) for error in errors) and len(errors) > 20
    assert issubclass(lg.NotDetectable, np.linalg.LinAlgError) and issubclass(lg.DimensionMismatch, ValueError)
    assert issubclass(lg.WrongDtype, TypeError)
    assert set(lg.errors.__all__) <= set(lg.__all__)


def test_an_exception_is_pickled_with_its_numbers():
    import pickle

    with pytest.raises(lg.DimensionMismatch) as found:
        lg.ss([[1.0, 2.0]], None, [[1.0]])
    again = pickle.loads(pickle.dumps(found.value))
    assert str(again) == str(found.value) and again.found == (1, 2) and isinstance(again, lg.DimensionMismatch)
