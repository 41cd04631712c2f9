//! The same study gives identical bytes, for any number of threads and any memory alignment.
#![allow(unsafe_code, reason = "an allocator is an unsafe trait; this one passes on, and moves what it gets")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use luenberger_study::{Format, RunOptions, Step, Study, execute, template};

/// Allocator that cycles through the offsets within a cache line: kernels that depend on alignment would sum in a
/// different order each time.
struct Shifting;

static NEXT: AtomicUsize = AtomicUsize::new(0);

/// Size of a cache line, and of the widest vector.
const LINE: usize = 64;

fn outer(layout: Layout) -> Option<Layout> {
    Layout::from_size_align(layout.size().checked_add(2 * LINE)?, LINE).ok()
}

// SAFETY: what is handed out lies at most two lines behind the start of a block that is two lines longer, at a multiple
// of the alignment asked for; how far, stands in the byte before it.
unsafe impl GlobalAlloc for Shifting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.align() >= LINE {
            // SAFETY: as required of the caller.
            return unsafe { System.alloc(layout) };
        }
        let Some(block) = outer(layout) else { return std::ptr::null_mut() };
        let step = layout.align().max(size_of::<usize>());
        let offset = LINE + NEXT.fetch_add(1, Ordering::Relaxed) * step % LINE;
        // SAFETY: the block is not empty; the byte before the offset and all that is asked for lie within it.
        unsafe {
            let start = System.alloc(block);
            if start.is_null() {
                return start;
            }
            let given = start.add(offset);
            // Below two lines, 128.
            given.sub(1).write(offset as u8);
            given
        }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as required of the caller; the byte before a pointer that `alloc` moved says how far.
        unsafe {
            match outer(layout) {
                Some(block) if layout.align() < LINE => {
                    let offset = usize::from(pointer.sub(1).read());
                    System.dealloc(pointer.sub(offset), block);
                }
                _ => System.dealloc(pointer, layout),
            }
        }
    }
}

#[global_allocator]
static ALLOCATOR: Shifting = Shifting;

/// The rod of twenty temperatures with a gain from inequalities in 271 unknowns: large enough for multithreaded
/// kernels, if enabled.
fn rod() -> Study {
    let text = template::template("heat-rod").unwrap().text;
    let (plant, _) = text.split_once("[[observer]]").unwrap();
    let observer = "[[observer]]\nname = \"inequalities\"\nkind = \"luenberger\"\ndecay_rate = 0.1\n";
    let initial = format!("initial = [{}]\n", ["20"; 20].join(", "));
    Study::from_text("rod.toml", &format!("{plant}{observer}{initial}"), Format::Toml, ".".as_ref()).unwrap()
}

/// The design with all digits, and its certificate.
fn design(study: &Study, threads: usize) -> (String, String) {
    let options = RunOptions { threads: Some(threads), ..RunOptions::default() };
    let results = execute(study, Step::Design, &options).unwrap();
    assert_eq!(results.failures(), Vec::<String>::new());
    let designed = luenberger_study::design::design(study, &study.observers[0], &AtomicBool::new(false)).unwrap();
    (results.to_json().unwrap(), designed.certificate.unwrap().file("rod").unwrap().to_json())
}

#[test]
fn a_design_by_inequalities_has_the_same_bytes_with_any_number_of_threads_anywhere_in_memory() {
    let study = rod();
    let first = design(&study, 1);
    for threads in [2, 3, 1] {
        let again = design(&study, threads);
        assert!(first.0 == again.0, "study.json with {threads} threads differs from that with one");
        assert!(first.1 == again.1, "the certificate with {threads} threads differs from that with one");
    }
}
