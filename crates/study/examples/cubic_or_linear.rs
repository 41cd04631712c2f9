//! When does the cubic term pay? The figure and the table of `docs/cubic-or-linear.md`.
//!
//! A double integrator, the poles -2 and -5, theta = 1. With errors in units of the first error the cubic observer has
//! two parameters: the strength `g = gamma |e(0)|^2` and the noise relative to the first error. It is compared with the
//! linear observer whose poles are those times a factor, so large that both have the same root mean square error under
//! the noise: the same noise gain.
//!
//! `cargo run --release -p luenberger-study --example cubic_or_linear -- docs/images` writes the figure.

use std::f64::consts::TAU;

use luenberger_design::{CubicDesign, CubicGain, LinearDesign, LyapunovWeight};
use luenberger_figures::figure::static_figure::png;
use luenberger_figures::{Figure, Hue, Mark, Panel, Series};
use nalgebra::{Matrix2, Vector2, dmatrix};

/// Strengths of the cubic term.
const STRENGTHS: [f64; 3] = [10.0, 100.0, 1000.0];

/// The error system `e' = F e - L v + g r^2 N r`, `r = e1 + v`.
struct ErrorSystem {
    f: Matrix2<f64>,
    l: Vector2<f64>,
    n: Vector2<f64>,
}

impl ErrorSystem {
    /// Poles `-2 k` and `-5 k`, and a cubic term of strength g.
    fn new(k: f64, g: f64) -> Result<Self, Box<dyn std::error::Error>> {
        let plant = luenberger_plants::double_integrator().to_dynamic();
        let linear =
            LinearDesign::with_poles_and_weight(&plant, &[-2.0 * k, -5.0 * k], LyapunovWeight::Identity(10.0))?;
        let l = Vector2::new(linear.l()[0], linear.l()[1]);
        let mut n = Vector2::zeros();
        if g > 0.0 {
            let cubic = CubicDesign::new(&linear, &dmatrix![1.0], &CubicGain::Gamma(g))?;
            n = Vector2::new(cubic.observer.n[0], cubic.observer.n[1]);
        }
        Ok(Self { f: Matrix2::new(-l[0], 1.0, -l[1], 0.0), l, n })
    }

    /// The error after the time h with the noise held, by steps as short as the cubic term is stiff.
    fn step(&self, mut e: Vector2<f64>, v: f64, mut h: f64) -> Vector2<f64> {
        while h > 0.0 {
            let stiffness = 3.0 * self.n.norm() * (e[0] + v).powi(2);
            let now = h.min(0.5 / stiffness);
            e = self.short_step(e, v, now);
            h -= now;
        }
        e
    }

    /// A step of Runge and Kutta's fourth order.
    fn short_step(&self, e: Vector2<f64>, v: f64, h: f64) -> Vector2<f64> {
        let slope = |e: Vector2<f64>| {
            let r = e[0] + v;
            self.f * e - self.l * v + self.n * r.powi(3)
        };
        let k1 = slope(e);
        let k2 = slope(e + k1 * (h / 2.0));
        let k3 = slope(e + k2 * (h / 2.0));
        let k4 = slope(e + k3 * h);
        e + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0)
    }

    /// Root mean square of |e| under uniform noise of this amplitude, held for 0.02.
    fn noise(&self, amplitude: f64) -> f64 {
        const HOLD: usize = 4;
        let (mut e, mut sum, mut count) = (Vector2::zeros(), 0.0, 0);
        let mut state = 1_u64;
        for k in 0..6000 {
            // Knuth's congruential generator: the same noise for every observer.
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let v = amplitude * ((state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0);
            for _ in 0..HOLD {
                e = self.step(e, v, 0.02 / HOLD as f64);
            }
            if k > 250 {
                sum += e.norm_squared();
                count += 1;
            }
        }
        (sum / f64::from(count)).sqrt()
    }

    /// Settling time to 5 % and the square root of the integral of |e|^2, from first errors of length 1: the medians
    /// over the directions.
    fn transient(&self) -> (f64, f64) {
        const H: f64 = 0.002;
        let (mut settling, mut cost) = (Vec::new(), Vec::new());
        for k in 0..24 {
            let angle = TAU * (f64::from(k) + 0.5) / 24.0;
            let (mut e, mut last, mut sum) = (Vector2::new(angle.cos(), angle.sin()), 0.0, 0.0);
            for step in 1..3000 {
                e = self.step(e, 0.0, H);
                sum += H * e.norm_squared();
                if e.norm() > 0.05 {
                    last = f64::from(step) * H;
                }
            }
            settling.push(last);
            cost.push(sum.sqrt());
        }
        let median = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            f64::midpoint(values[11], values[12])
        };
        (median(&mut settling), median(&mut cost))
    }
}

/// The factor of the poles at which the linear observer has this root mean square error for noise of amplitude 1.
fn factor_for(rms: f64) -> Result<f64, Box<dyn std::error::Error>> {
    let (mut low, mut high) = (1.0_f64, 30.0_f64);
    for _ in 0..18 {
        let middle = (low * high).sqrt();
        if ErrorSystem::new(middle, 0.0)?.noise(1.0) < rms { low = middle } else { high = middle }
    }
    Ok((low * high).sqrt())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1);
    let ratios: Vec<f64> = (0..9).map(|k| 0.003 * f64::powf(200.0, f64::from(k) / 8.0)).collect();
    let base = ErrorSystem::new(1.0, 0.0)?.noise(1.0);
    let panel = |title: &str, label: &str| {
        Panel::new("amplitude of the noise / initial error", label).title(title).log_x().mark(Mark::horizontal(1.0))
    };
    let mut settling = panel("Settling time, equal noise gain", "cubic / linear");
    let mut error = panel("Accumulated error, equal noise gain", "cubic / linear");
    let mut inflation = panel("Error under noise, the same L", "cubic / linear");
    println!("    g   noise/|e(0)|   error under noise   factor of the poles   settling   accumulated error");
    for (number, g) in STRENGTHS.into_iter().enumerate() {
        let cubic = ErrorSystem::new(1.0, g)?;
        let (time, cost) = cubic.transient();
        let mut rows: [Vec<f64>; 3] = Default::default();
        for ratio in &ratios {
            let rms = cubic.noise(*ratio) / ratio;
            let factor = factor_for(rms.max(base))?;
            let (of_linear, cost_of_linear) = ErrorSystem::new(factor, 0.0)?.transient();
            let row = [time / of_linear, cost / cost_of_linear, rms / base];
            println!("{g:5}   {ratio:12.4}   {:17.3}   {factor:19.3}   {:8.3}   {:17.3}", row[2], row[0], row[1]);
            rows.iter_mut().zip(row).for_each(|(column, x)| column.push(x));
        }
        let curve = |y: &[f64]| Series::line(format!("g = {g}"), &ratios, y).hue(Hue::Palette(number));
        settling = settling.series(curve(&rows[0]));
        error = error.series(curve(&rows[1]));
        inflation = inflation.series(curve(&rows[2]));
        // The noise costs more the larger it is, and the cubic observer is never quieter.
        assert!(rows[2].windows(2).all(|pair| pair[1] > 0.99 * pair[0]) && rows[2][0] > 0.99);
    }
    let figure = Figure::new("Cubic or linear?")
        .caption("Medians over the directions of the initial error; below 1 the cubic observer is better.")
        .panel(inflation)
        .panel(settling)
        .panel(error)
        .columns(3);
    if let Some(folder) = folder {
        std::fs::write(std::path::Path::new(&folder).join("cubic-or-linear.png"), png(&figure)?)?;
    }
    Ok(())
}
