"""Observers of any kind, by the keys of a study."""

import re
from pathlib import Path

import luenberger as lg
import numpy as np
import pytest

SYS = lg.ss([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])


def test_every_kind_says_what_it_is():
    kinds = lg.kinds()
    page = Path(__file__).parents[3] / "docs" / "kinds.md"
    assert list(kinds) == re.findall(r"^\| `([a-z0-9-]+)` \|", page.read_text(), re.MULTILINE)
    for name, kind in kinds.items():
        assert kind.name == name and kind.about and kind.source and kind.plants
        assert set(kind.required) <= set(kind.keys) and all(kind.keys.values())


def test_a_kind_with_a_function_of_its_own_is_the_same():
    poles = np.array([-2.0, -5.0])
    observer = lg.observer("luenberger", SYS, poles=poles, xhat0=[1, 0])
    same = lg.place_observer(SYS, poles, xhat0=[1, 0])
    np.testing.assert_array_equal(observer.L, same.L)
    assert observer.kind == "luenberger" and observer.verdict == same.verdict == "proved"
    complex_poles = lg.observer("luenberger", SYS, poles=[-1 + 1j, -1 - 1j])
    # s^2 + 2 s + 2.
    np.testing.assert_allclose(complex_poles.L.ravel(), [2, 2], rtol=1e-13)


def test_kinds_without_a_function_of_their_own():
    # x1 is measured, w' = -3 w + .. for x2: T = (-3, 1).
    reduced = lg.observer("reduced-order", SYS, poles=[-3])
    np.testing.assert_allclose(reduced.poles, [-3])
    extended = lg.observer("extended-state", SYS, e=np.array([[0.0], [1.0]]), bandwidth=np.float64(3))
    # (s + 3)^3 = s^3 + 9 s^2 + 27 s + 27.
    np.testing.assert_allclose(extended.L.ravel(), [9, 27, 27], rtol=1e-12)
    sliding = lg.observer("sliding-mode", SYS, bound=1, period=0.01)
    np.testing.assert_allclose(sliding.matrices["k"].ravel(), [2.1, 1.1], rtol=1e-12)
    plant = lg.plant(["-x1 + u"], ["x1"], states=["x1"], inputs=["u"])
    region = {"states": [[-1, 1]], "inputs": [[-1, 1]]}
    kkl = lg.observer(
        "kkl", plant, {"lambda": [-2]}, phi=["x1"], b=["y1 + u"], left_inverse=["xi1"], region=region
    )
    assert kkl.verdict == "proved"
    everywhere = lg.observer("lpv", plant, region={"states": [(-np.inf, np.inf)]})
    assert everywhere.verdict == "proved"


def test_bad_input_has_a_clear_error():
    with pytest.raises(lg.InvalidArgument, match="no kind of observers 'kalmann'; the nearest is 'kalman'"):
        lg.observer("kalmann", SYS)
    with pytest.raises(lg.InvalidArgument, match="`pols` is not a key"):
        lg.observer("luenberger", SYS, pols=[-1, -2])
    with pytest.raises(lg.InvalidArgument, match="the kind sliding-mode has no `bound`"):
        lg.observer("sliding-mode", SYS, period=0.1)
    with pytest.raises(lg.InvalidArgument, match="gain is an array of object"):
        lg.observer("luenberger", SYS, gain=np.array([[object()], [None]]))
    with pytest.raises(lg.InvalidArgument, match="poles"):
        lg.observer("luenberger", SYS, poles=[np.nan, -1])
    with pytest.raises(lg.NotApplicable, match="is for plants in continuous time"):
        lg.observer("high-gain", lg.ss([[0.5, 1], [0, 0.5]], [[0], [1]], [[1, 0]], dt=0.1), r=0.1)


def test_keys_of_any_collection_and_what_is_none():
    expected = lg.observer("luenberger", SYS, poles=[-1, -2]).L
    for poles in ({-2, -1}, (p for p in (-1, -2)), map(float, ["-1", "-2"]), range(-2, 0)):
        np.testing.assert_allclose(lg.observer("luenberger", SYS, poles=poles).L, expected, rtol=1e-12)
    with pytest.raises(lg.InvalidArgument, match="neither a number nor a text"):
        lg.observer("kalman", SYS, w=object(), v=1)
