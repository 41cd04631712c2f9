"""What a user does who has the wheel and numpy, and nothing else."""

import importlib.util
import pathlib
import tempfile

import luenberger

for name in ("control", "scipy", "matplotlib", "tqdm"):
    assert importlib.util.find_spec(name) is None, f"{name} is installed here"

sys = luenberger.ss([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
assert luenberger.observability(sys).is_observable
observer = luenberger.place_observer(sys, [-4, -5])
run = observer.simulate([1, -1], 4, u="sin(t)")
assert abs(run.error[:, -1]).max() < 1e-5
with tempfile.TemporaryDirectory() as folder:
    path = observer.certificate.save(pathlib.Path(folder) / "observer.json")
    assert luenberger.verify(path).facts
    assert observer.export(pathlib.Path(folder) / "c", dt=0.01).proved
pendulum = luenberger.plant(["w", "-sin(a)"], ["a"], states=["a", "w"])
assert luenberger.lpv_observer(pendulum).verdict == "proved"
for missing in (run.plot, observer.to_control):
    try:
        missing()
    except ModuleNotFoundError:
        pass
    else:
        raise AssertionError("an optional package is not installed")
print("luenberger", luenberger.__version__, "works with numpy alone")
