//! Ticks of an axis, and the place of a value on it.

use luenberger_figures::figure::Scale;
use luenberger_figures::internals::Axis;

fn labels(from: f64, to: f64, scale: Scale) -> (Vec<String>, String) {
    let ticks = Axis { from, to, scale }.ticks(5);
    (ticks.major.into_iter().map(|(_, label)| label).collect(), ticks.factor)
}

#[test]
fn linear_ticks_are_round_and_say_their_power_of_ten_once() {
    assert_eq!(labels(0.0, 4.0, Scale::Linear).0, ["0", "1", "2", "3", "4"]);
    assert_eq!(labels(-3.1, 1.2, Scale::Linear).0, ["−3", "−2", "−1", "0", "1"]);
    assert_eq!(labels(0.0, 1.0, Scale::Linear).0, ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
    assert_eq!(
        labels(0.0, 250_000.0, Scale::Linear),
        (["0", "0.5", "1.0", "1.5", "2.0", "2.5"].map(String::from).to_vec(), "×10⁵".to_owned())
    );
    assert_eq!(labels(0.0, 0.01, Scale::Linear).1, "");
    assert_eq!(labels(0.0, 0.004, Scale::Linear).1, "×10⁻³");
}

#[test]
fn log_ticks_are_powers_of_ten_unless_these_are_too_few_or_too_many() {
    assert_eq!(labels(1e-3, 10.0, Scale::Log).0, ["0.001", "0.01", "0.1", "1", "10"]);
    assert_eq!(labels(1e-12, 1.0, Scale::Log).0, ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "10⁰"]);
    assert_eq!(labels(1.5, 30.0, Scale::Log).0, ["2", "5", "10", "20"]);
    assert_eq!(labels(0.8, 1.3, Scale::Log).0, ["0.8", "0.9", "1.0", "1.1", "1.2", "1.3"]);
    let few = ["0.8", "1.0", "1.2", "1.4", "1.6", "1.8", "2.0", "2.2", "2.4"].map(String::from).to_vec();
    assert_eq!(labels(7e-4, 2.4e-3, Scale::Log), (few, "×10⁻³".to_owned()));
}

#[test]
fn the_ends_of_an_axis_lie_at_zero_and_one() {
    for axis in [Axis { from: -2.0, to: 5.0, scale: Scale::Linear }, Axis { from: 1e-6, to: 1e3, scale: Scale::Log }] {
        assert_eq!(axis.place(axis.from), 0.0);
        assert_eq!(axis.place(axis.to), 1.0);
    }
    let log = Axis { from: 1.0, to: 100.0, scale: Scale::Log };
    assert_eq!(log.place(10.0), 0.5);
}
