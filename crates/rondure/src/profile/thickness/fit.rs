//! Cubics along a parallel that is none itself: end points and end tangents are exact, the lengths of
//! the two handles are what makes the cubic keep its distance best.
//!
//! With the handles a and b the cubic is
//!
//! ```text
//! B(u) = p0 B0 + (p0 + a t0) B1 + (p1 - b t1) B2 + p1 B3,    B1 = 3 u (1-u)^2, B2 = 3 u^2 (1-u),
//! ```
//!
//! and at its foot point s on the curve, where (B - c) . c' = 0, it is off by e = (B - c) . n - d. Moving a
//! handle changes e by B1 t0 . n, or -B2 t1 . n, to first order: Gauss and Newton find the best two. What is
//! still too far off is halved. The error falls with the sixth power of the length.

use super::parallel::{Parallel, dot, jet, right, tangent};
use super::{Point, Segment};

/// No deeper than this: below it the halves are as short as the rounding of s.
const DEEPEST: u32 = 24;

/// The places on a cubic at which its distance is measured.
const PLACES: usize = 9;

/// Appends cubics along a parallel from s = `from` to `to`, where it is at the points `ends`, off by no
/// more than `tolerance`. `None` if there is no tangent, as at a cusp.
pub(super) fn fit(
    parallel: &Parallel<'_>,
    [from, to]: [f64; 2],
    ends: [Point; 2],
    tolerance: f64,
    out: &mut Vec<Segment>,
) -> Option<()> {
    let mut waiting = vec![([from, to], ends, 0)];
    while let Some(([from, to], ends, depth)) = waiting.pop() {
        let tangents = [tangent(parallel.segment, from)?, tangent(parallel.segment, to)?];
        let fitted = best(parallel, [from, to], ends, tangents, tolerance);
        if let Some(cubic) = fitted {
            out.push(Segment::Cubic(cubic));
            continue;
        }
        if depth == DEEPEST {
            out.push(Segment::Line(ends));
            continue;
        }
        let middle = 0.5 * (from + to);
        let point = parallel.point(middle)?;
        waiting.push(([middle, to], [point, ends[1]], depth + 1));
        waiting.push(([from, middle], [ends[0], point], depth + 1));
    }
    Some(())
}

fn best(
    parallel: &Parallel<'_>,
    range: [f64; 2],
    [p0, p1]: [Point; 2],
    [t0, t1]: [Point; 2],
    tolerance: f64,
) -> Option<[Point; 4]> {
    const STEPS: usize = 4;
    let third = (range[1] - range[0]) / 3.0;
    let handle = |s: f64, t: Point| parallel.jet(s).map(|(_, velocity)| dot(velocity, t) * third);
    let (mut a, mut b) = (handle(range[0], t0)?, handle(range[1], t1)?);
    let chord = (p1 - p0).length();
    for step in 0..=STEPS {
        if !(a >= 0.0 && b >= 0.0 && a + b <= 3.0 * chord) {
            return None;
        }
        let cubic = [p0, p0 + t0 * a, p1 - t1 * b, p1];
        let mut worst = 0.0_f64;
        let [mut aa, mut ab, mut bb, mut ae, mut be] = [0.0; 5];
        for k in 1..=PLACES {
            let u = k as f64 / (PLACES + 1) as f64;
            let (error, normal) = distance(parallel, range, &cubic, u)?;
            worst = worst.max(error.abs());
            let (by_a, by_b) = (
                3.0 * u * (1.0 - u) * (1.0 - u) * dot(t0, normal),
                -3.0 * u * u * (1.0 - u) * dot(t1, normal),
            );
            aa += by_a * by_a;
            ab += by_a * by_b;
            bb += by_b * by_b;
            ae += by_a * error;
            be += by_b * error;
        }
        // Between the places it is hardly farther off than at the worst of them.
        if 1.25 * worst <= tolerance {
            return Some(cubic);
        }
        let determinant = aa * bb - ab * ab;
        if step == STEPS || determinant <= f64::EPSILON * aa * bb {
            return None;
        }
        a -= (ae * bb - be * ab) / determinant;
        b -= (be * aa - ae * ab) / determinant;
    }
    None
}

/// How much farther than d the cubic's point at u is from the curve, and the curve's normal there.
fn distance(
    parallel: &Parallel<'_>,
    [from, to]: [f64; 2],
    [a, b, c, d]: &[Point; 4],
    u: f64,
) -> Option<(f64, Point)> {
    const STEPS: usize = 8;
    let v = 1.0 - u;
    let point =
        *a * (v * v * v) + *b * (3.0 * v * v * u) + *c * (3.0 * v * u * u) + *d * (u * u * u);
    let mut s = from + (to - from) * u;
    for _ in 0..STEPS {
        let at = jet(parallel.segment, s);
        let away = point - at.point;
        let slope = dot(at.first, at.first) - dot(away, at.second);
        let step = dot(away, at.first) / slope;
        let next = (s + step).clamp(from, to);
        let done = (next - s).abs() <= f64::EPSILON;
        s = next;
        if done {
            break;
        }
    }
    let normal = right(tangent(parallel.segment, s)?);
    let error = dot(point - parallel.segment.point(s), normal) - parallel.d;
    error.is_finite().then_some((error, normal))
}
