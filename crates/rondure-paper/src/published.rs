//! The numbers that the paper prints in its Tables 1 and 2.

use rondure::Method;

/// One entry: what the paper prints for a method.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Published {
    pub(crate) seconds: f64,
    /// In percent.
    pub(crate) visited: f64,
    /// In millions.
    pub(crate) intersections: f64,
}

/// The entry for a scene (0: Table 1, 1: Table 2). For KJ there is only one, which stands for both.
pub(crate) fn entry(scene: usize, method: Method, subdivided: bool) -> Option<Published> {
    let (seconds, intersections, visited) = match (scene, method, subdivided) {
        (0, Method::Kj, _) => (15.44, 9.67, 0.02),
        (0, Method::Cy, true) => (5.54, 10.26, 0.02),
        (0, Method::Cy, false) => (6.86, 10.37, 0.02),
        (0, Method::Co, true) => (5.60, 10.38, 0.02),
        (0, Method::Co, false) => (7.60, 10.63, 0.02),
        (0, Method::Hy, true) => (5.44, 10.18, 0.02),
        (0, Method::Hy, false) => (6.93, 10.28, 0.02),
        (1, Method::Kj, _) => (32.78, 21.34, 0.02),
        (1, Method::Cy, true) => (17.96, 25.15, 0.03),
        (1, Method::Cy, false) => (20.92, 25.65, 0.03),
        (1, Method::Co, true) => (18.22, 26.09, 0.03),
        (1, Method::Co, false) => (22.48, 26.71, 0.03),
        (1, Method::Hy, true) => (17.75, 24.88, 0.03),
        (1, Method::Hy, false) => (20.83, 25.38, 0.03),
        _ => return None,
    };
    Some(Published { seconds, visited, intersections })
}
