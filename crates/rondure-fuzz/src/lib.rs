//! What must hold of `rondure` whatever bytes it is given: the bodies of the fuzz targets.
//!
//! The targets in `fuzz/` hand their input on to one of [`TARGETS`]; the test `replay` hands it every
//! file in `fuzz/seeds`. Each is a function of the bytes alone and panics if something is wrong.

mod profile;
mod scene;
mod trace;

pub use profile::profile;
pub use scene::scene;
pub use trace::trace;

/// All targets, by the name of their folder of seeds.
pub const TARGETS: [(&str, Target); 3] = [("profile", profile), ("scene", scene), ("trace", trace)];

/// Takes any bytes, and panics if what must hold does not.
pub type Target = fn(&[u8]);

use rondure_scene::Report;

/// Whether what is shown for bad input can be shown.
fn check_report(report: &Report) {
    for text in [report.plain(), report.colored()] {
        assert!(!text.is_empty(), "nothing is said about bad input");
    }
    let plain = report.plain();
    assert!(!plain.contains(|c: char| c.is_control() && c != '\n'), "control characters are shown");
}
