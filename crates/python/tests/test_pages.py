"""The programs of the READMEs and of the page on Python, as they are printed there."""

import pathlib
import re

import control
import numpy as np
import pandas
import pytest

import luenberger as lg

ROOT = pathlib.Path(__file__).parents[3]
STUDY = """
[plant]
a = [[0, 1], [-2, -3]]
c = [[1, 0]]
[simulation]
x0 = [1, -1]
duration = 2
[[observer]]
name = "fast"
kind = "luenberger"
poles = [-4, -5]
[sweep]
parameter = "initial"
values = [1, 2]
"""


def programs(page):
    return re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)


@pytest.mark.parametrize("page", ["README.md", "crates/python/README.md", "docs/python.md"])
def test_ten_lines_give_a_proved_observer(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (program,) = [text for text in programs(page) if "place_observer" in text]
    assert len([line for line in program.splitlines() if line.strip()]) <= 10
    exec(program, {})
    assert "proved" in capsys.readouterr().out
    assert lg.verify("observer.json").facts


def test_the_other_programs_of_the_page(tmp_path, monkeypatch, capsys):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY)
    page = programs("docs/python.md")
    (study,) = [text for text in page if "study.run" in text]
    names = {"luenberger": lg, "pandas": pandas}
    exec(study, names)
    assert names["results"].verdicts == {"fast": "proved"} and (tmp_path / "study-results" / "report.html").is_file()
    (errors,) = [text for text in page if "NotDetectable" in text]
    hidden = {"A": np.diag([1.0, -1.0]), "G": np.eye(2), "C": [[0.0, 1.0]], "QN": 1.0, "RN": 1.0}
    exec(errors, {"luenberger": lg, "control": control, **hidden})
    assert "(1+0j) 0.0" in capsys.readouterr().out


def test_the_programs_on_logs_and_angles(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = programs("docs/python.md")
    (log,) = [text for text in page if "study.tune" in text]
    random = np.random.default_rng(1)
    level, rows = 0.0, []
    for k in range(300):
        voltage = float(k % 20 < 10)
        rows.append({"t": 0.1 * k, "voltage": voltage, "tacho": level + 0.2 * random.normal()})
        level += 0.1 * (2.4 * voltage - 0.9 * level) + 0.05 * random.normal()
    pandas.DataFrame(rows).to_csv("log.csv", index=False)
    text = """
[plant]
states = ["speed"]
inputs = ["voltage"]
outputs = ["tacho"]
parameters = { friction = 0.7 }
f = ["speed + 0.1*(2.4*voltage - friction*speed)"]
h = ["speed"]
dt = 0.1
[log]
file = "log.csv"
[[observer]]
name = "filter"
kind = "extended-kalman"
w = [0.01]
v = [0.01]
period = 0.1
[tune]
observer = "filter"
parameters = ["w", "friction"]
profile = 0
"""
    names = {"luenberger": lg, "pandas": pandas, "rows": rows, "study": lg.Study.from_text(text, folder=tmp_path)}
    exec(log, names)
    assert names["stream"].samples == 300 and set(names["estimate"]) == {"t", "speed_hat", "speed_2sigma"}
    (angles,) = [text for text in page if "angles=" in text]
    exec(angles, names)
    assert names["observer"].kind == "extended-kalman"
