//! Small-bulge multishift QR iteration with aggressive early deflation, for larger Hessenberg matrices (Braman, Byers,
//! Mathias, SIAM J. Matrix Anal. Appl. 23, 2002, part I; LAPACK dlaqr0 and dlaqr5; Granat, Kagstrom, Kressner, ACM TOMS
//! 41, 2015).
//!
//! A train of bulges, three rows apart, moves down the active block, one window at a time. Inside the window each bulge
//! is chased; outside, all chains of reflectors are applied to a few rows at a time while these are in the cache.
//! Reflectors are not accumulated into a matrix: with the chains of `chain.rs` the 3 s^2 multiply-adds per row and 2 s
//! columns take about as long as the 4 s^2 of a product with the accumulated matrix.

use super::bulge::{STEPS, Way, chase};
use super::chain::{Chain, Reflector, WIDTH, chain_on_columns, pack, strip, unpack};
use super::deflation::{Iterate, Window};
use super::francis::{SWEEPS_PER_ROW, Shifts, first_of_active_block, shifted_column};
use super::standard::standardise;
use crate::kernel::{Kernel, dispatch};

/// Active blocks up to this order use the double-shift iteration.
pub(super) const SMALL: usize = 75;
/// Sweeps without deflation before the shifts are replaced by exceptional ones.
const PATIENCE: usize = 6;
/// Sweeps without deflation before the window grows.
const NARROW: usize = 5;
/// Percentage of the window that must deflate for another window to be tried before the next sweep.
const NIBBLE: usize = 14;
/// Rows between two bulges of a train.
const SPACING: usize = 3;

/// Rows copied and reflected together.
const TALL: usize = 2 * WIDTH;

/// Number of shifts of a sweep for a matrix of this order, as in LAPACK. Measured alternatives: with 16 to 32 shifts
/// and windows of 32 to 48, order 100 takes 30 to 70 % longer and order 300 up to 6 %; with 48 to 80 and 72 to 128,
/// order 1000 takes as long or slightly longer.
fn shift_count(order: usize) -> usize {
    match order {
        0..150 => 10,
        150..590 => (order as f64 / (order as f64).log2().round()) as usize & !1,
        590..3000 => 64,
        _ => 128,
    }
}

/// Order of the deflation window for a matrix of this order.
fn window_order(n: usize) -> usize {
    if n <= 500 { shift_count(n) } else { 3 * shift_count(n) / 2 }
}

/// Workspace of the iteration.
#[derive(Default)]
pub(super) struct Space {
    window: Window,
    pairs: Vec<Shifts>,
    ways: Vec<Way>,
    reflectors: Vec<Reflector>,
    packed: Vec<f64>,
}

/// The iteration on the Hessenberg matrix of `m`, which becomes its real Schur form (only the diagonal blocks unless
/// `m.whole`). Returns the number of leading rows that have not converged: zero, unless the maximum number of sweeps is
/// reached.
pub(super) fn multishift(m: &mut Iterate<'_>, space: &mut Space) -> usize {
    let n = m.n;
    let largest = (n / 3).max(SMALL).min(n);
    let cap = SWEEPS_PER_ROW * n;
    let mut end = n;
    let mut stalled = 0;
    for _ in 0..cap {
        if end <= 1 {
            return 0;
        }
        let last = end - 1;
        let first = first_of_active_block(m.h, n, last);
        if first > 0 {
            m.h[(first - 1) * n + first] = 0.0;
        }
        let order = end - first;
        if order == 1 {
            end = first;
            continue;
        }
        if order <= SMALL {
            let found = space.window.deflate(m, first, first, order);
            if found.stuck > 0 {
                return first + found.stuck;
            }
            end = first;
            stalled = 0;
            continue;
        }
        let usual = window_order(n).min(order).min(largest);
        let window = if stalled < NARROW { usual } else { (usual << (stalled - NARROW + 1).min(8)).min(largest) };
        let mut at = end - window;
        // Starts the window at the smaller of two neighbouring subdiagonal entries.
        if at > first + 1 && m.h[(at - 1) * n + at].abs() > m.h[(at - 2) * n + at - 1].abs() {
            at -= 1;
        }
        let window = end - at;
        let found = space.window.deflate(m, first, at, window);
        end -= found.rows;
        let order = end - first;
        if found.rows > 0 {
            stalled = 0;
        }
        if order <= SMALL || (found.rows > 0 && 100 * found.rows > NIBBLE * window) {
            continue;
        }
        stalled += 1;
        let count = shift_count(n).min(order - 1).max(2) & !1;
        if stalled % PATIENCE == 0 {
            exceptional(m, first, end, count, space);
        } else {
            if space.window.values.len() <= count / 2 {
                space.window.shifts_of(m, end - count, count);
            }
            paired(space, count / 2);
        }
        sweep(m, first, end - 1, space);
    }
    end
}

/// Exceptional shifts from the diagonal and subdiagonal, for matrices that the ordinary shifts map to themselves; the
/// constants are those of LAPACK.
fn exceptional(m: &Iterate<'_>, first: usize, end: usize, count: usize, space: &mut Space) {
    let n = m.n;
    space.pairs.clear();
    let mut i = end - 1;
    while space.pairs.len() < count / 2 && i >= first + 2 {
        let s = m.h[(i - 1) * n + i].abs() + m.h[(i - 2) * n + i - 1].abs();
        let centre = 0.75 * s + m.h[i * n + i];
        let [[a, b], [c, d]] = standardise([[centre, s], [-0.4375 * s, centre]]).block;
        let im = b.abs().sqrt() * c.abs().sqrt();
        space.pairs.push(Shifts { re: [a, d], im: [im, -im] });
        i -= 2;
    }
}

/// Pairs of shifts, conjugate or real, at most `most`: those of smallest modulus, which converge first.
fn paired(space: &mut Space, most: usize) {
    let Space { window, pairs, .. } = space;
    let size = |s: &(f64, f64)| s.0.abs() + s.1.abs();
    pairs.clear();
    let values = &mut window.values;
    values.sort_by(|x, y| size(x).total_cmp(&size(y)));
    let mut waiting = None;
    for &(re, im) in values.iter() {
        if pairs.len() == most {
            break;
        }
        if im > 0.0 {
            pairs.push(Shifts { re: [re, re], im: [im, -im] });
        } else if im == 0.0 {
            match waiting.take() {
                None => waiting = Some(re),
                Some(other) => pairs.push(Shifts { re: [other, re], im: [0.0; 2] }),
            }
        }
    }
    if let (true, Some(re)) = (pairs.is_empty(), waiting) {
        pairs.push(Shifts { re: [re, re], im: [0.0; 2] });
    }
}

/// One sweep: the bulges of `space.pairs` pass through the active block `first..=last`.
fn sweep(m: &mut Iterate<'_>, first: usize, last: usize, space: &mut Space) {
    let n = m.n;
    let Space { pairs, ways, reflectors, packed, .. } = space;
    if pairs.is_empty() {
        return;
    }
    let advance = (2 * pairs.len()).max(24);
    let (top, right) = if m.whole { (0, n) } else { (first, last + 1) };
    let room = advance + SPACING * pairs.len() + 4;
    reflectors.resize(pairs.len() * advance, Reflector::default());
    packed.resize(TALL * room.max(STEPS + 2), 0.0);
    ways.clear();
    ways.resize(pairs.len(), Way { from: first, to: first, last, window: (0, 0), entry: None });
    let mut front = first;
    while ways.last().is_some_and(|way| way.to < last) {
        front += advance;
        let (mut lowest, mut highest) = (usize::MAX, 0);
        for (k, way) in ways.iter_mut().enumerate() {
            way.from = way.to;
            way.to = front.saturating_sub(SPACING * k).clamp(way.from, last);
            way.entry = None;
            if way.from < way.to {
                (lowest, highest) = (lowest.min(way.from), highest.max(way.to));
            }
        }
        let window = (lowest, (highest + 2).min(last + 1));
        for way in ways.iter_mut() {
            way.window = window;
        }
        dispatch(Train { h: m.h, n, first, pairs, ways, reflectors, advance, packed });
        let far = |data: &mut [f64], ld: usize, range: core::ops::Range<usize>, by_rows: bool, packed: &mut [f64]| {
            dispatch(Far { data, ld, range, by_rows, window, ways, reflectors, advance, packed });
        };
        far(m.h, n, top..lowest, false, packed);
        far(m.h, n, window.1..right, true, packed);
        if let Some(rows) = m.q.len().checked_div(n) {
            far(m.q, rows, 0..rows, false, packed);
        }
    }
}

/// Chases the bulges inside the window.
struct Train<'a> {
    h: &'a mut [f64],
    n: usize,
    first: usize,
    pairs: &'a [Shifts],
    ways: &'a [Way],
    reflectors: &'a mut [Reflector],
    advance: usize,
    packed: &'a mut [f64],
}

impl Kernel for Train<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self { h, n, first, pairs, ways, reflectors, advance, packed } = self;
        for ((way, pair), chain) in ways.iter().zip(pairs).zip(reflectors.chunks_exact_mut(advance)) {
            if way.from == way.to {
                continue;
            }
            let mut way = *way;
            if way.from == first {
                way.entry = Some(shifted_column(h, n, first, *pair));
            }
            chase::<FMA>(h, n, way, &mut chain[..way.to - way.from], packed);
        }
    }
}

/// Applies the chains of all bulges to rows or columns outside the window.
struct Far<'a> {
    data: &'a mut [f64],
    ld: usize,
    range: core::ops::Range<usize>,
    by_rows: bool,
    window: (usize, usize),
    ways: &'a [Way],
    reflectors: &'a [Reflector],
    advance: usize,
    packed: &'a mut [f64],
}

impl Kernel for Far<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self { data, ld, range, by_rows, window: (low, high), ways, reflectors, advance, packed } = self;
        let chains = || {
            ways.iter().zip(reflectors.chunks_exact(advance)).filter(|(way, _)| way.from < way.to).map(
                |(way, chain)| Chain {
                    at: way.from,
                    reflectors: &chain[..way.to - way.from],
                    pair: way.to == way.last,
                },
            )
        };
        let span = high - low;
        let mut k = range.start;
        while k < range.end {
            if by_rows {
                let end = range.end.min(k + WIDTH);
                let columns = &mut data[k * ld..end * ld];
                pack::<WIDTH>(columns, ld, low, span, packed);
                for chain in chains() {
                    strip::<WIDTH, FMA>(packed, WIDTH, 0, Chain { at: chain.at - low, ..chain });
                }
                unpack::<WIDTH>(columns, ld, low, span, packed);
                k = end;
            } else if k + TALL <= range.end {
                // Neighbouring columns lie on different memory pages; a copy does not. Copying pays off for several
                // rows at once.
                let block = &mut data[low * ld + k..];
                for (row, column) in packed.chunks_exact_mut(TALL).zip(block.chunks(ld)).take(span) {
                    row.copy_from_slice(&column[..TALL]);
                }
                for part in (0..TALL).step_by(WIDTH) {
                    for chain in chains() {
                        strip::<WIDTH, FMA>(packed, TALL, part, Chain { at: chain.at - low, ..chain });
                    }
                }
                for (row, column) in packed.chunks_exact(TALL).zip(block.chunks_mut(ld)).take(span) {
                    column[..TALL].copy_from_slice(row);
                }
                k += TALL;
            } else {
                let end = range.end.min(k + WIDTH);
                for chain in chains() {
                    chain_on_columns::<FMA>(data, ld, k..end, chain);
                }
                k = end;
            }
        }
    }
}
