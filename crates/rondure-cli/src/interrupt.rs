//! Ctrl-C: the wish to stop.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use crate::failure::INTERRUPTED;

/// A flag that Ctrl-C sets. The second Ctrl-C does not wait any more.
pub(crate) fn flag() -> Arc<AtomicBool> {
    let cancelled = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&cancelled);
    let handler = move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED.into());
        }
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        anstream::eprintln!("warning: Ctrl-C will stop the work at once: {error}");
    }
    cancelled
}
