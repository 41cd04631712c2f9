//! A step of a sampled observer of unknown size takes no memory, and neither does a step of an integrator.
#![allow(unsafe_code, reason = "a counting allocator is an unsafe trait; it only passes on")]

use luenberger_observers::{DiscreteLinearObserver, SampledCubicGains, SampledCubicObserver, SampledObserver, cubic};
use luenberger_plants::StateSpace;
use luenberger_sim::{Integrator, Settings, solve};
use nalgebra::{DMatrix, DVector, dmatrix};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: as required of the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as required of the caller.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations<R>(work: impl FnOnce() -> R) -> usize {
    let before = COUNT.with(Cell::get);
    black_box(work());
    COUNT.with(Cell::get) - before
}

#[test]
fn steps_of_sampled_observers_take_no_memory() {
    let (ad, bd, c) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0]);
    let (ld, n) = (dmatrix![0.9; 2.0], dmatrix![-1.0; -1.5]);
    let (theta, w, period) = (dmatrix![10.0], cubic::rate(&c, &n), 0.1);
    let plant = StateSpace::new(ad.clone(), bd.clone(), c.clone()).unwrap();
    let linear = DiscreteLinearObserver::new(plant, ld.clone(), period).unwrap();
    let gains = SampledCubicGains { ad, bd, c, ld, n, theta, w, period };
    let cubic = SampledCubicObserver::new(gains).unwrap().with_feedthrough(dmatrix![0.5]).unwrap();
    let (mut xhat, u, y) = (DVector::zeros(2), DVector::from_element(1, 0.3), DVector::from_element(1, 1.0));
    assert_eq!(allocations(|| (0..100).for_each(|_| linear.step(0.0, &mut xhat, &u, &y))), 0);
    assert_eq!(allocations(|| (0..100).for_each(|_| cubic.step(0.0, &mut xhat, &u, &y))), 0);
    assert!(xhat.iter().all(|x| x.is_finite()));
    assert_eq!(allocations(|| DMatrix::<f64>::zeros(2, 2)), 1, "the allocator counts");
}

/// What a solution keeps grows by doubling; everything else is allocated once.
#[test]
fn steps_of_the_explicit_integrator_take_no_memory() {
    let oscillator =
        |_: f64, x: &[f64], slope: &mut [f64]| (slope[0], slope[1]) = (x[1], (1.0 - x[0] * x[0]) * x[1] - x[0]);
    let settings = Settings { integrator: Integrator::Explicit, rtol: 1e-9, atol: 1e-12, ..Settings::default() };
    let count = |end: f64| {
        let mut steps = 0;
        let count = allocations(|| steps = solve(oscillator, 0.0, end, &[1.0, 0.0], &settings).unwrap().step_count());
        (count, steps)
    };
    let ((few, short), (many, long)) = (count(1.0), count(100.0));
    assert!(long > 50 * short && many < few + 30, "{few} for {short} steps, {many} for {long}");
}
