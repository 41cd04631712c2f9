"""Makes log.csv and raw.csv: a lithium-ion cell of 850 mAh under a varying load, as a data logger would have recorded it.

The cell is the circuit of M. Chen and G. A. Rincon-Mora, Accurate electrical battery model capable of predicting
runtime and I-V performance, IEEE Transactions on Energy Conversion 21(2), 2006, equations (2) to (6): open-circuit
voltage, series resistance and two RC pairs, all functions of the state of charge, with the printed coefficients. Its
temperature is that of one heat capacity (18 J/K, 8 K/W to the surroundings of 25 degrees Celsius).

The log has what logs have: noise and quantisation, a logger that was off from t = 1500 to 1900 s, a voltage sensor
that failed for a minute, six outliers, and a temperature every 10 s only. The true state of charge is written beside
it, as a reference instrument would have it.

raw.csv is the same as the logger wrote it: milliseconds of the epoch, integers in mA, mV and thousandths of a degree,
the last temperature repeated until the next one, NaN for the sensor that failed, and a first column of numbers.

Run with Python 3 and numpy: python make_log.py > log.csv; python make_log.py raw > raw.csv
"""

import math
import sys

import numpy as np

CAPACITY = 3060.0  # 850 mAh in As
START = 1714564800000  # 2024-05-01 12:00:00 UTC in ms


def open_circuit_voltage(soc):
    return -1.031 * math.exp(-35 * soc) + 3.685 + 0.2156 * soc - 0.1178 * soc**2 + 0.3201 * soc**3


def parameters(soc):
    """Series resistance; resistance and capacitance of the short and of the long transient."""
    return (
        0.1562 * math.exp(-24.37 * soc) + 0.07446,
        (0.3208 * math.exp(-29.14 * soc) + 0.04669, -752.9 * math.exp(-13.51 * soc) + 703.6),
        (6.603 * math.exp(-155.2 * soc) + 0.04984, -6056.0 * math.exp(-27.12 * soc) + 4475.0),
    )


def main(raw):
    random = np.random.default_rng(2026)
    # The load: a new level every 5 to 40 s, between charging with 0.4 A and discharging with 1.5 A, and some rests.
    load = []
    while len(load) < 3600:
        level = 0.0 if random.random() < 0.2 else random.uniform(-0.4, 1.5)
        load += [level] * int(random.integers(5, 41))
    dropout = range(2400, 2460)
    outliers = {700: 0.35, 1210: -0.5, 2050: 0.4, 2051: 0.45, 2800: -0.3, 3100: 0.6}
    soc, short, long, temperature = 0.95, 0.0, 0.0, 25.0
    print(",stamp,i_mA,u_mV,t_mdegC,soc_ref" if raw else "t [s],current [A],voltage [V],temperature [degC],soc_true [-]")
    count = 0
    for t in range(3600):
        current = load[t]
        series, _, _ = parameters(soc)
        voltage = open_circuit_voltage(soc) - short - long - series * current
        seen = voltage + random.normal(0.0, 0.005) + outliers.get(t, 0.0)
        drawn = current + random.normal(0.0, 0.005)
        felt = temperature + random.normal(0.0, 0.1)
        if t % 10 == 0:
            held = felt
        if raw and not 1500 < t < 1900:
            cells = [
                f"{count}",
                f"{START + 1000 * t}",
                f"{1000 * drawn:.0f}",
                "NaN" if t in dropout else f"{1000 * seen:.0f}",
                f"{1000 * held:.0f}",
                f"{soc:.5f}",
            ]
            print(",".join(cells))
            count += 1
        elif not 1500 < t < 1900:
            cells = [
                f"{t}",
                f"{drawn:.3f}",
                "" if t in dropout else f"{seen:.3f}",
                f"{felt:.1f}" if t % 10 == 0 else "",
                f"{soc:.5f}",
            ]
            print(",".join(cells))
        # A hundred steps of Euler's method a second; the shortest time constant is 30 s.
        step = 0.01
        for _ in range(100):
            series, (r1, c1), (r2, c2) = parameters(soc)
            heat = series * current**2 + short**2 / r1 + long**2 / r2
            soc -= step * current / CAPACITY
            short += step * (current - short / r1) / c1
            long += step * (current - long / r2) / c2
            temperature += step * (heat - (temperature - 25.0) / 8.0) / 18.0


if __name__ == "__main__":
    main(sys.argv[1:] == ["raw"])
