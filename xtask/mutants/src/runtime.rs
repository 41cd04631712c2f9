
#[doc(hidden)]
mod luenberger_mutants {
    extern crate std;

    use std::fs::{File, OpenOptions};
    use std::io::Write as _;
    use std::sync::OnceLock;
    use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

    /// The environment is not read yet; what is reached is written down.
    const UNREAD: u32 = u32::MAX;
    const RECORDING: u32 = u32::MAX - 1;

    static ACTIVE: AtomicU32 = AtomicU32::new(UNREAD);
    static REACHED: [AtomicBool; COUNT] = [const { AtomicBool::new(false) }; COUNT];
    static RECORD: OnceLock<File> = OnceLock::new();

    /// Whether the `count` mutants from `first` on are off.
    #[inline]
    pub(crate) fn off(first: u32, count: u32) -> bool {
        let active = ACTIVE.load(Relaxed);
        if active >= RECORDING { ask(first, count) } else { active.wrapping_sub(first) >= count }
    }

    #[inline]
    pub(crate) fn on(id: u32) -> bool {
        ACTIVE.load(Relaxed) == id
    }

    #[cold]
    #[inline(never)]
    fn ask(first: u32, count: u32) -> bool {
        if ACTIVE.load(Relaxed) == UNREAD {
            let id = std::env::var("LUENBERGER_MUTANT").ok().and_then(|id| id.parse().ok());
            let file = std::env::var("LUENBERGER_MUTANTS_REACHED").ok();
            let file = file.and_then(|path| OpenOptions::new().create(true).append(true).open(path).ok());
            let recording = file.is_some();
            if let Some(file) = file {
                RECORD.get_or_init(|| file);
            }
            ACTIVE.store(if recording { RECORDING } else { id.unwrap_or(0) }, Relaxed);
        }
        let active = ACTIVE.load(Relaxed);
        if active != RECORDING {
            return active.wrapping_sub(first) >= count;
        }
        if !REACHED[first as usize].swap(true, Relaxed) {
            if let Some(mut file) = RECORD.get() {
                let _ = file.write_all(std::format!("{first}\n").as_bytes());
            }
        }
        true
    }
}
