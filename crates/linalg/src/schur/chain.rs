//! Chains of reflectors of order three, each one row below the previous one: the transformations of one bulge.
//!
//! The iteration needs each reflector immediately only near the diagonal; elsewhere several are applied together. Each
//! entry of a column is then loaded and stored once per bulge instead of three times (the restructuring of Van Zee, van
//! de Geijn and Quintana-Orti, ACM TOMS 40, 2014, for reflectors). From the right a chain works on columns, which are
//! contiguous; from the left it works on a transposed copy of a few columns.

use crate::kernel::fma;

/// `I - tau v v'` with `v = (1, v[0], v[1])` and `t = tau v`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reflector {
    pub(super) v: [f64; 2],
    pub(super) t: [f64; 3],
}

/// Reflectors for rows (or columns) `at..at + 3`, `at + 1..at + 4`, ...; with `pair` the last one has order two.
#[derive(Clone, Copy)]
pub(super) struct Chain<'a> {
    pub(super) at: usize,
    pub(super) reflectors: &'a [Reflector],
    pub(super) pair: bool,
}

impl Chain<'_> {
    /// Number of rows (columns) that the chain changes.
    #[inline(always)]
    pub(super) fn span(&self) -> usize {
        self.reflectors.len() + if self.pair { 1 } else { 2 }
    }
}

/// Rows packed and reflected together: four registers of four.
pub(super) const WIDTH: usize = 16;

/// Applies the chain to rows `rows` of `data` from the right.
#[inline(always)]
pub(super) fn chain_on_columns<const FMA: bool>(
    data: &mut [f64],
    ld: usize,
    rows: core::ops::Range<usize>,
    chain: Chain<'_>,
) {
    let mut row = rows.start;
    while row + WIDTH <= rows.end {
        strip::<WIDTH, FMA>(data, ld, row, chain);
        row += WIDTH;
    }
    if row + 8 <= rows.end {
        strip::<8, FMA>(data, ld, row, chain);
        row += 8;
    }
    if row + 4 <= rows.end {
        strip::<4, FMA>(data, ld, row, chain);
        row += 4;
    }
    if row < rows.end {
        partial::<FMA>(data, ld, row..rows.end, chain);
    }
}

/// Applies the chain to fewer than four rows.
#[inline(always)]
fn partial<const FMA: bool>(data: &mut [f64], ld: usize, rows: core::ops::Range<usize>, chain: Chain<'_>) {
    let (row, count) = (rows.start, rows.len().min(4));
    let read = |data: &[f64], offset: usize| {
        let mut x = [0.0; 4];
        x.iter_mut().zip(&data[offset..offset + count]).for_each(|(x, e)| *x = *e);
        x
    };
    let mut offset = chain.at * ld + row;
    let mut x = read(data, offset);
    let mut y = read(data, offset + ld);
    let triples = chain.reflectors.len() - usize::from(chain.pair);
    for r in &chain.reflectors[..triples] {
        let mut z = read(data, offset + 2 * ld);
        reflect3::<4, FMA>(r, &mut x, &mut y, &mut z);
        data[offset..offset + count].copy_from_slice(&x[..count]);
        (x, y) = (y, z);
        offset += ld;
    }
    if let (true, Some(r)) = (chain.pair, chain.reflectors.last()) {
        reflect2::<4, FMA>(r, &mut x, &mut y);
    }
    data[offset..offset + count].copy_from_slice(&x[..count]);
    data[offset + ld..offset + ld + count].copy_from_slice(&y[..count]);
}

/// Applies a reflector to three columns (or rows).
#[inline(always)]
pub(super) fn reflect3<const W: usize, const FMA: bool>(
    r: &Reflector,
    x: &mut [f64; W],
    y: &mut [f64; W],
    z: &mut [f64; W],
) {
    for l in 0..W {
        let s = fma::<FMA>(r.t[1], y[l], fma::<FMA>(r.t[0], x[l], r.t[2] * z[l]));
        x[l] -= s;
        y[l] = fma::<FMA>(-s, r.v[0], y[l]);
        z[l] = fma::<FMA>(-s, r.v[1], z[l]);
    }
}

/// Applies a reflector of order two to two columns (or rows).
#[inline(always)]
pub(super) fn reflect2<const W: usize, const FMA: bool>(r: &Reflector, x: &mut [f64; W], y: &mut [f64; W]) {
    for l in 0..W {
        let s = fma::<FMA>(r.t[1], y[l], r.t[0] * x[l]);
        x[l] -= s;
        y[l] = fma::<FMA>(-s, r.v[0], y[l]);
    }
}

#[inline(always)]
fn load<const W: usize>(data: &[f64], offset: usize) -> [f64; W] {
    data.get(offset..).and_then(|d| d.first_chunk::<W>()).copied().unwrap_or([0.0; W])
}

#[inline(always)]
fn store<const W: usize>(data: &mut [f64], offset: usize, x: [f64; W]) {
    if let Some(place) = data.get_mut(offset..).and_then(|d| d.first_chunk_mut::<W>()) {
        *place = x;
    }
}

/// Applies the chain to rows `row..row + W`.
#[inline(always)]
pub(super) fn strip<const W: usize, const FMA: bool>(data: &mut [f64], ld: usize, row: usize, chain: Chain<'_>) {
    let mut offset = chain.at * ld + row;
    let mut x = load::<W>(data, offset);
    let mut y = load::<W>(data, offset + ld);
    let triples = chain.reflectors.len() - usize::from(chain.pair);
    for r in &chain.reflectors[..triples] {
        let mut z = load::<W>(data, offset + 2 * ld);
        reflect3::<W, FMA>(r, &mut x, &mut y, &mut z);
        store(data, offset, x);
        (x, y) = (y, z);
        offset += ld;
    }
    if let (true, Some(r)) = (chain.pair, chain.reflectors.last()) {
        reflect2::<W, FMA>(r, &mut x, &mut y);
    }
    store(data, offset, x);
    store(data, offset + ld, y);
}

/// Copies rows `at..at + span` of the columns in `columns` to `packed`, transposed: entry (i, l) at `i * W + l`.
/// Missing columns are filled with zeros.
#[inline(always)]
pub(super) fn pack<const W: usize>(columns: &[f64], ld: usize, at: usize, span: usize, packed: &mut [f64]) {
    let count = columns.len() / ld;
    let mut l = 0;
    while l < W {
        if l + 4 <= count {
            let part = |k: usize| &columns[(l + k) * ld + at..(l + k) * ld + at + span];
            let (a, b, c, d) = (part(0), part(1), part(2), part(3));
            for ((((row, a), b), c), d) in packed.chunks_exact_mut(W).zip(a).zip(b).zip(c).zip(d) {
                row[l] = *a;
                row[l + 1] = *b;
                row[l + 2] = *c;
                row[l + 3] = *d;
            }
            l += 4;
        } else {
            for (i, row) in packed.chunks_exact_mut(W).enumerate().take(span) {
                row[l] = if l < count { columns[l * ld + at + i] } else { 0.0 };
            }
            l += 1;
        }
    }
}

/// Inverse of [`pack`].
#[inline(always)]
pub(super) fn unpack<const W: usize>(columns: &mut [f64], ld: usize, at: usize, span: usize, packed: &[f64]) {
    for (l, column) in columns.chunks_exact_mut(ld).enumerate().take(W) {
        for (e, row) in column[at..at + span].iter_mut().zip(packed.chunks_exact(W)) {
            *e = row[l];
        }
    }
}

/// Applies the chain to the columns `cols` of `data` from the left; `packed` has room for `WIDTH * span` entries.
#[inline(always)]
pub(super) fn chain_on_rows<const FMA: bool>(
    data: &mut [f64],
    ld: usize,
    cols: core::ops::Range<usize>,
    chain: Chain<'_>,
    packed: &mut [f64],
) {
    let mut col = cols.start;
    while col + 8 < cols.end {
        let end = cols.end.min(col + WIDTH);
        rows_of::<WIDTH, FMA>(&mut data[col * ld..end * ld], ld, chain, packed);
        col = end;
    }
    while col < cols.end {
        let end = cols.end.min(col + 4);
        rows_of::<4, FMA>(&mut data[col * ld..end * ld], ld, chain, packed);
        col = end;
    }
}

#[inline(always)]
fn rows_of<const W: usize, const FMA: bool>(columns: &mut [f64], ld: usize, chain: Chain<'_>, packed: &mut [f64]) {
    let span = chain.span();
    pack::<W>(columns, ld, chain.at, span, packed);
    strip::<W, FMA>(packed, W, 0, Chain { at: 0, ..chain });
    unpack::<W>(columns, ld, chain.at, span, packed);
}
