//! Tests of the clock that a program registers.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use luenberger_clock::page::Instant;
use luenberger_clock::set_clock;

/// Milliseconds.
static TIME: AtomicU64 = AtomicU64::new(0);

/// Time stands still without a clock, and is that of the first one that was registered afterwards.
#[test]
fn the_registered_clock_is_read() {
    let began = Instant::now();
    assert_eq!((began, began.elapsed()), (Instant::now(), Duration::ZERO));
    set_clock(|| TIME.load(Ordering::Relaxed) as f64);
    set_clock(|| 1e9);
    TIME.store(1500, Ordering::Relaxed);
    assert_eq!(began.elapsed(), Duration::from_millis(1500));
    let end = began + Duration::from_secs(2);
    assert!(Instant::now() < end && Some(end) == began.checked_add(Duration::from_secs(2)));
    assert_eq!(end - Instant::now(), Duration::from_millis(500));
    // An instant in the past is no time away, and one beyond all is the last one.
    assert_eq!((Instant::now() - end, began.duration_since(end)), (Duration::ZERO, Duration::ZERO));
    assert_eq!((began.checked_add(Duration::MAX).map(|last| last + Duration::MAX)), Some(end + Duration::MAX));
    assert_eq!(end.checked_add(Duration::MAX), None);
}
