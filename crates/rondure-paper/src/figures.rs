//! Pictures that explain, drawn from the data structures themselves: the paper's Figures 1 to 4.
//!
//! Every curve, shell, tree and interval in them is asked from a [`Surface`]; only places of labels
//! are chosen by hand.

mod half_plane;
mod intervals;
mod shell_and_ray;
mod shells;
mod tree;

use rondure::{EngineOptions, Method, Profile, Surface};

/// All figures, by file name.
pub fn all() -> [(&'static str, String); 4] {
    [
        ("fig1.svg", shell_and_ray::figure()),
        ("fig2.svg", intervals::figure()),
        ("fig3.svg", tree::figure()),
        ("fig4.svg", shells::figure()),
    ]
}

/// A vase, two units high, whose outline turns four times.
const VASE: &str = "M 0 0 L 0.55 0 C 0.3 0.22 0.98 0.4 0.92 0.85 C 0.86 1.3 0.3 1.3 0.3 1.62 \
                    C 0.3 1.8 0.44 1.92 0.6 2";

/// A part of a profile that bulges.
const WALL: &str = "M 0.9 0.3 C 1.15 0.55 1.5 0.75 1.55 1.2";

const INK: &str = "#1f2430";
const FAINT: &str = "#8a93a3";
const RAY: &str = "#d1242f";
const CURVE: &str = "#1f2430";
const CYLINDER: &str = "#2f6fb3";
const CONE: &str = "#d9822b";
/// Colours that tell neighbouring monotone intervals apart.
const INTERVALS: [&str; 6] = ["#2f6fb3", "#d9822b", "#3a9a5b", "#9b59b6", "#c0392b", "#16889b"];

/// The engine of a method over a path.
fn surface(path: &str, method: Method, samples: u32, subdivide: u32) -> Option<Surface> {
    let profile = Profile::from_path_data(path).ok()?;
    let options = EngineOptions { method, samples, subdivide, ..EngineOptions::default() };
    Some(Surface::with_engine(&profile, &options))
}

/// The attributes of a line.
fn stroke(color: &str, width: f64) -> String {
    format!("fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\"")
}

/// The attributes of a dashed line.
fn dashed(color: &str, width: f64) -> String {
    format!("{} stroke-dasharray=\"5 4\"", stroke(color, width))
}

/// The attributes of a translucent area with an outline.
fn area(color: &str, opacity: f64, width: f64) -> String {
    format!(
        "fill=\"{color}\" fill-opacity=\"{opacity}\" stroke=\"{color}\" stroke-width=\"{width}\""
    )
}
