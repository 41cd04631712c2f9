//! Integrates one problem with this project or with another Rust crate, as requested on the command line.
//!
//! ```text
//! sim-bench luenberger cubic 1e-9 100      {"us": of one solution, "end": [final state], "calls": of the right-hand side}
//! ```
//! The absolute tolerance is a thousandth of the relative one. Only the solution is timed, with what the caller gets of
//! it: here the dense output, with `Scenario` every quantity of plant and observer as well, elsewhere the final state.

use differential_equations::prelude::{ExplicitRungeKutta, IVP, ODE};
use diffsol::{NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod};
use luenberger_observers::CubicObserver;
use luenberger_sim::{Integrator, Scenario, Settings, solve};
use nalgebra::{Matrix1, Vector2};
use serde_json::json;
use std::cell::Cell;
use std::hint::black_box;
use std::time::Instant;

/// Example 1 of the cubic-observer paper: gains with poles -2 and -5, theta = 10, gamma = 2.
const L: [f64; 2] = [7.0, 10.0];
const N: [f64; 2] = [-168.0 / 17.0, -196.0 / 17.0];
const THETA: f64 = 10.0;

/// A right-hand side, and its derivative in a direction.
type Rhs = fn(&[f64], &mut [f64]);
type Derivative = fn(&[f64], &[f64], &mut [f64]);

struct Problem {
    f: Rhs,
    derivative: Derivative,
    start: &'static [f64],
    end: f64,
}

/// Double integrator and cubic observer.
fn cubic(x: &[f64], slope: &mut [f64]) {
    let y = x[0] - x[2];
    let pull = THETA * y * y * y;
    (slope[0], slope[1]) = (x[1], 0.0);
    (slope[2], slope[3]) = (x[3] + L[0] * y - N[0] * pull, L[1] * y - N[1] * pull);
}

fn cubic_derivative(x: &[f64], d: &[f64], out: &mut [f64]) {
    let (y, v) = (x[0] - x[2], d[0] - d[2]);
    let pull = 3.0 * THETA * y * y * v;
    (out[0], out[1]) = (d[1], 0.0);
    (out[2], out[3]) = (d[3] + L[0] * v - N[0] * pull, L[1] * v - N[1] * pull);
}

fn van_der_pol(mu: f64, x: &[f64], slope: &mut [f64]) {
    (slope[0], slope[1]) = (x[1], mu * (1.0 - x[0] * x[0]) * x[1] - x[0]);
}

fn van_der_pol_derivative(mu: f64, x: &[f64], d: &[f64], out: &mut [f64]) {
    (out[0], out[1]) = (d[1], mu * ((1.0 - x[0] * x[0]) * d[1] - 2.0 * x[0] * x[1] * d[0]) - d[0]);
}

/// Robertson's reactions.
fn robertson(x: &[f64], slope: &mut [f64]) {
    let (slow, fast, faster) = (0.04 * x[0], 1e4 * x[1] * x[2], 3e7 * x[1] * x[1]);
    (slope[0], slope[1], slope[2]) = (fast - slow, slow - fast - faster, faster);
}

fn robertson_derivative(x: &[f64], d: &[f64], out: &mut [f64]) {
    let (slow, fast, faster) = (0.04 * d[0], 1e4 * (d[1] * x[2] + x[1] * d[2]), 6e7 * x[1] * d[1]);
    (out[0], out[1], out[2]) = (fast - slow, slow - fast - faster, faster);
}

/// A chain of twenty masses between springs with little damping.
fn chain(x: &[f64], slope: &mut [f64]) {
    let n = x.len() / 2;
    for i in 0..n {
        let (left, right) = (if i == 0 { 0.0 } else { x[i - 1] }, if i + 1 == n { 0.0 } else { x[i + 1] });
        slope[i] = x[n + i];
        slope[n + i] = left - 2.0 * x[i] + right - 0.1 * x[n + i];
    }
}

const CHAIN: [f64; 40] = {
    let mut start = [0.0; 40];
    start[0] = 1.0;
    start
};

fn problem(name: &str) -> Option<Problem> {
    Some(match name {
        "cubic" => Problem { f: cubic, derivative: cubic_derivative, start: &[3.0, 3.0, 0.0, 0.0], end: 4.0 },
        "van-der-pol" => Problem {
            f: |x, slope| van_der_pol(5.0, x, slope),
            derivative: |x, d, out| van_der_pol_derivative(5.0, x, d, out),
            start: &[2.0, 0.0],
            end: 20.0,
        },
        "stiff-van-der-pol" => Problem {
            f: |x, slope| van_der_pol(1000.0, x, slope),
            derivative: |x, d, out| van_der_pol_derivative(1000.0, x, d, out),
            start: &[2.0, 0.0],
            end: 2000.0,
        },
        "stiff-robertson" => {
            Problem { f: robertson, derivative: robertson_derivative, start: &[1.0, 0.0, 0.0], end: 4e6 }
        }
        "chain" => Problem { f: chain, derivative: |_, d, out| chain(d, out), start: &CHAIN, end: 20.0 },
        _ => return None,
    })
}

/// The final state and the calls of the right-hand side.
type Answer = Result<(Vec<f64>, usize), String>;

fn ours(problem: &Problem, rtol: f64) -> Answer {
    let calls = Cell::new(0);
    let f = |_: f64, x: &[f64], slope: &mut [f64]| {
        calls.set(calls.get() + 1);
        (problem.f)(x, slope);
    };
    let settings = Settings { integrator: Integrator::Auto, rtol, atol: rtol * 1e-3, ..Settings::default() };
    let solution = solve(f, 0.0, problem.end, problem.start, &settings).map_err(|error| error.to_string())?;
    let end = solution.at(problem.end).map_err(|error| error.to_string())?;
    Ok((end, calls.get()))
}

/// Plant and observer as they are, with input, output, estimate and error along the run.
fn scenario(rtol: f64) -> Answer {
    let plant = luenberger_plants::double_integrator();
    let observer = CubicObserver::new(plant.a, plant.b, plant.c, L.into(), N.into(), Matrix1::new(THETA));
    let observer = observer.map_err(|error| error.to_string())?;
    let run = Scenario::new(plant)
        .initial_state(&[3.0, 3.0])
        .observer("cubic", observer, Vector2::zeros().as_slice())
        .until(4.0, 2)
        .tolerances(rtol, rtol * 1e-3)
        .run()
        .map_err(|error| error.to_string())?;
    let estimate = run.observer_state_at("cubic", 4.0).map_err(|error| error.to_string())?;
    Ok(([run.state_at(4.0).map_err(|error| error.to_string())?, estimate].concat(), 0))
}

struct Sized<const SIZE: usize>(Rhs, Cell<usize>);

impl<const SIZE: usize> ODE<f64, [f64; SIZE]> for Sized<SIZE> {
    fn diff(&self, _: f64, x: &[f64; SIZE], slope: &mut [f64; SIZE]) {
        self.1.set(self.1.get() + 1);
        (self.0)(x, slope);
    }
}

fn differential_equations<const SIZE: usize>(problem: &Problem, rtol: f64) -> Answer {
    let start: [f64; SIZE] = problem.start.try_into().map_err(|_| "another number of states")?;
    let ode = Sized(problem.f, Cell::new(0));
    let method = ExplicitRungeKutta::dop853().rtol(rtol).atol(rtol * 1e-3).max_steps(10_000_000);
    let solution = IVP::ode(&ode, 0.0, problem.end, start).method(method).solve();
    let solution = solution.map_err(|error| format!("{error:?}"))?;
    let end = solution.y.last().ok_or("no step")?.to_vec();
    Ok((end, ode.1.get()))
}

fn diffsol(problem: &Problem, rtol: f64) -> Answer {
    type M = NalgebraMat<f64>;
    let (f, derivative, start) = (problem.f, problem.derivative, problem.start);
    let built = OdeBuilder::<M>::new()
        .rtol(rtol)
        .atol([rtol * 1e-3])
        .rhs_implicit(
            move |x: &[f64], _: &[f64], _, out: &mut [f64]| f(x, out),
            move |x: &[f64], _: &[f64], _, d: &[f64], out: &mut [f64]| derivative(x, d, out),
        )
        .init(move |_: &[f64], _, out: &mut [f64]| out.copy_from_slice(start), start.len())
        .build()
        .map_err(|error| error.to_string())?;
    let mut solver = built.bdf::<NalgebraLU<f64>>().map_err(|error| error.to_string())?;
    let (solution, _) = solver.solve_dense(&[problem.end]).map_err(|error| error.to_string())?;
    Ok(((0..start.len()).map(|i| solution[(i, 0)]).collect(), 0))
}

fn call(who: &str, problem: &Problem, rtol: f64) -> Answer {
    match who {
        "luenberger" => ours(problem, rtol),
        "scenario" => scenario(rtol),
        "differential-equations" => match problem.start.len() {
            2 => differential_equations::<2>(problem, rtol),
            4 => differential_equations::<4>(problem, rtol),
            _ => differential_equations::<40>(problem, rtol),
        },
        "diffsol" => diffsol(problem, rtol),
        _ => Err(format!("there is no {who}")),
    }
}

/// Blocks of calls, of which the fastest counts.
const BLOCKS: u32 = 10;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [who, name, rtol, times] = &arguments[..] else { panic!("WHO PROBLEM RTOL TIMES") };
    let problem = problem(name).expect("a known problem");
    let rtol: f64 = rtol.parse().expect("a number");
    let times: u32 = times.parse().expect("a number");
    let mut answer = call(who, &problem, rtol);
    // What else the machine does takes time from some blocks of calls, not from all.
    let (mut us, block) = (f64::INFINITY, times.div_ceil(BLOCKS));
    for _ in 0..BLOCKS {
        let start = Instant::now();
        for _ in 0..block {
            answer = black_box(call(who, &problem, rtol));
        }
        us = us.min(start.elapsed().as_secs_f64() * 1e6 / f64::from(block));
    }
    match answer {
        Ok((end, calls)) => println!("{}", json!({"us": us, "end": end, "calls": calls})),
        Err(error) => println!("{}", json!({"error": error})),
    }
}
