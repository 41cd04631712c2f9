//! Work on all cores. Results do not depend on the number of threads.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use std::thread;

/// `f(0), ..., f(count - 1)`.
///
/// Each thread begins with a share of neighbours, because these often read the same shared result, for which one of two
/// threads would wait. A thread without work takes over the upper half of the largest share.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let threads = thread::available_parallelism().map_or(1, usize::from).min(count.max(1));
    let bound = |k: usize| k * count / threads;
    let shares: Mutex<Vec<Range<usize>>> = Mutex::new((0..threads).map(|k| bound(k)..bound(k + 1)).collect());
    let next = |own: usize| {
        let mut shares = shares.lock().unwrap_or_else(PoisonError::into_inner);
        if shares[own].is_empty() {
            let largest = (0..threads).max_by_key(|&k| shares[k].len())?;
            let Range { start, end } = shares[largest].clone();
            let middle = start + (end - start) / 2;
            shares[largest].end = middle;
            shares[own] = middle..end;
        }
        shares[own].next()
    };
    let work = &|own: usize| {
        let mut found = Vec::new();
        while let Some(k) = next(own) {
            found.push((k, f(k)));
        }
        found
    };
    let mut found = thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|own| scope.spawn(move || work(own))).collect();
        let mut found = work(0);
        for other in others {
            found.extend(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        found
    });
    found.sort_by_key(|(k, _)| *k);
    found.into_iter().map(|(_, one)| one).collect()
}
