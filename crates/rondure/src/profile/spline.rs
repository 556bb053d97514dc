//! A profile through given points: a polyline, or a smooth curve.
//!
//! Both smooth curves are cubic Hermite splines over chord lengths: the parameter grows by the
//! distance h between neighbouring points, so that unevenly spaced points give no loops (Lee 1989,
//! "Choosing nodes in parametric curve interpolation"; de Boor, "A Practical Guide to Splines", ch.
//! 4). With a tangent v at each point, the segment from p to q is the Bézier curve
//!
//! ```text
//! p,  p + h/3 v_p,  q - h/3 v_q,  q
//! ```
//!
//! Only the tangents differ: the natural spline's make the second derivative continuous, the
//! Catmull-Rom spline's are the difference of the two neighbours over their distance in parameter.

use super::{Point, Profile, ProfileError, ProfileErrorKind};

/// How a curve runs through given points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spline {
    /// Straight from point to point.
    Polyline,
    /// Natural cubic spline: continuous curvature, none at the ends.
    Natural,
    /// Catmull-Rom spline: the tangent at a point is parallel to the line between its neighbours;
    /// the first and the last segment are parabolas.
    CatmullRom,
}

impl Profile {
    /// The profile through the points, in their order; closed if the last point equals the first,
    /// and then smooth there too.
    ///
    /// A point that is given twice in a row is a corner: a smooth curve ends there and a new one
    /// begins. A polyline has corners anyway; the second copy changes nothing. So the segments
    /// count the steps from each point to the next different one.
    ///
    /// # Errors
    ///
    /// [`ProfileError`] if there are fewer than two points, or the curve fails the checks of
    /// [`ProfileBuilder::build`](super::ProfileBuilder::build): a smooth curve can leave r >= 0
    /// although its points do not.
    pub fn through_points(points: &[Point], spline: Spline) -> Result<Self, ProfileError> {
        if points.len() < 2 {
            return Err(ProfileErrorKind::TooFewPoints { found: points.len() }.into());
        }
        let knots = Knots::new(points);
        // `build` refuses these before their chords overflow.
        let tame = |p: &Point| p.r.abs().max(p.z.abs()) <= super::builder::LARGEST;
        let smooth = points.iter().all(tame) && spline != Spline::Polyline;
        let curves = if smooth { knots.smooth(spline) } else { vec![None; knots.points.len() - 1] };
        let start = knots.points[0];
        let mut builder = Self::builder().move_to(start.r, start.z);
        if knots.points.len() == 1 {
            builder = builder.line_to(start.r, start.z);
        }
        for (end, curve) in knots.points[1..].iter().zip(curves) {
            builder = match curve {
                Some([c1, c2]) => builder.cubic_to([c1.r, c1.z], [c2.r, c2.z], end.r, end.z),
                None => builder.line_to(end.r, end.z),
            };
        }
        builder.build()
    }
}

/// The points without repetitions, and where the curve has corners.
struct Knots {
    points: Vec<Point>,
    corners: Vec<bool>,
}

/// The inner control points of a cubic; `None` for a straight line.
type Curve = Option<[Point; 2]>;

impl Knots {
    fn new(given: &[Point]) -> Self {
        let mut knots = Self { points: vec![given[0]], corners: vec![false] };
        for pair in given.windows(2) {
            if pair[0] == pair[1] {
                if let Some(corner) = knots.corners.last_mut() {
                    *corner = true;
                }
            } else {
                knots.points.push(pair[1]);
                knots.corners.push(false);
            }
        }
        knots
    }

    fn is_closed(&self) -> bool {
        self.points.len() > 1 && self.points.first() == self.points.last()
    }

    /// The curve of each step, from the runs between corners. On a closed chain a run may pass the
    /// seam.
    fn smooth(&self, spline: Spline) -> Vec<Curve> {
        let steps = self.points.len() - 1;
        let closed = self.is_closed();
        let corner =
            |i: usize| self.corners[i] || (closed && i == 0 && self.corners[steps]) || i == steps;
        let mut curves = vec![None; steps];
        let first = if closed { (0..steps).find(|&i| corner(i)) } else { Some(0) };
        let Some(first) = first else {
            curves.copy_from_slice(&periodic(&self.points[..steps], spline));
            return curves;
        };
        let index = |i: usize| if closed { i % steps } else { i };
        let mut at = 0;
        while at < steps {
            // The run from the corner `first + at` to the next one, both included.
            let mut run = vec![self.points[index(first + at)]];
            let begin = at;
            loop {
                at += 1;
                let i = index(first + at);
                run.push(self.points[i]);
                if at == steps || corner(i) {
                    break;
                }
            }
            for (offset, curve) in open(&run, spline).into_iter().enumerate() {
                curves[(first + begin + offset) % steps] = curve;
            }
        }
        curves
    }
}

/// Steps of a chain: their lengths h and their directions d = (q - p) / h.
struct Chords {
    lengths: Vec<f64>,
    slopes: Vec<Point>,
}

impl Chords {
    fn new(steps: impl Iterator<Item = (Point, Point)>) -> Self {
        let (lengths, slopes) = steps
            .map(|(p, q)| {
                let length = (q - p).length();
                (length, (q - p) * length.recip())
            })
            .unzip();
        Self { lengths, slopes }
    }

    /// The Catmull-Rom tangent between the steps i and j.
    fn between(&self, i: usize, j: usize) -> Point {
        let (h, k) = (self.lengths[i], self.lengths[j]);
        (self.slopes[i] * h + self.slopes[j] * k) * (h + k).recip()
    }

    /// The equation for the natural spline's tangent between the steps i and j: k v_i +
    /// 2 (h + k) v + h v_j = 3 (k d_i + h d_j).
    fn equation(&self, i: usize, j: usize) -> Row {
        let (h, k) = (self.lengths[i], self.lengths[j]);
        let right = (self.slopes[i] * k + self.slopes[j] * h) * 3.0;
        Row { left: k, diagonal: 2.0 * (h + k), right: h, value: right }
    }

    fn controls(&self, i: usize, p: Point, q: Point, v: Point, w: Point) -> Curve {
        let third = self.lengths[i] / 3.0;
        Some([p + v * third, q - w * third])
    }
}

/// One equation of a tridiagonal system.
#[derive(Clone, Copy)]
struct Row {
    left: f64,
    diagonal: f64,
    right: f64,
    value: Point,
}

/// The curves of an open run of points.
fn open(points: &[Point], spline: Spline) -> Vec<Curve> {
    let steps = points.len() - 1;
    if steps < 2 {
        return vec![None; steps];
    }
    let chords = Chords::new(points.windows(2).map(|p| (p[0], p[1])));
    let inner = 1..steps;
    let (d_first, d_last) = (chords.slopes[0], chords.slopes[steps - 1]);
    let tangents = if spline == Spline::Natural {
        let end =
            |d: Point, left: f64| Row { left, diagonal: 2.0, right: 1.0 - left, value: d * 3.0 };
        let rows = core::iter::once(end(d_first, 0.0))
            .chain(inner.map(|i| chords.equation(i - 1, i)))
            .chain([end(d_last, 1.0)]);
        solve(&rows.collect::<Vec<_>>())
    } else {
        let mut tangents = vec![Point::default()];
        tangents.extend(inner.map(|i| chords.between(i - 1, i)));
        tangents[0] = d_first * 2.0 - tangents[1];
        tangents.push(d_last * 2.0 - tangents[steps - 1]);
        tangents
    };
    (0..steps)
        .map(|i| chords.controls(i, points[i], points[i + 1], tangents[i], tangents[i + 1]))
        .collect()
}

/// The curves of a closed run without a corner; the last step leads back to the first point.
fn periodic(points: &[Point], spline: Spline) -> Vec<Curve> {
    let n = points.len();
    if n < 3 {
        return vec![None; n];
    }
    let next = |i: usize| (i + 1) % n;
    let chords = Chords::new((0..n).map(|i| (points[i], points[next(i)])));
    let before = |i: usize| (i + n - 1) % n;
    let tangents = if spline == Spline::Natural {
        solve_cyclic(&(0..n).map(|i| chords.equation(before(i), i)).collect::<Vec<_>>())
    } else {
        (0..n).map(|i| chords.between(before(i), i)).collect()
    };
    (0..n)
        .map(|i| chords.controls(i, points[i], points[next(i)], tangents[i], tangents[next(i)]))
        .collect()
}

/// Solves a tridiagonal system (Thomas). Every row's diagonal is at least twice the rest of it, so
/// that no pivot is needed (Higham, section 9.6).
fn solve(rows: &[Row]) -> Vec<Point> {
    let mut ratio = Vec::with_capacity(rows.len());
    let mut values: Vec<Point> = Vec::with_capacity(rows.len());
    let (mut previous_ratio, mut previous) = (0.0, Point::default());
    for row in rows {
        let pivot = row.diagonal - row.left * previous_ratio;
        previous_ratio = row.right / pivot;
        previous = (row.value - previous * row.left) * pivot.recip();
        ratio.push(previous_ratio);
        values.push(previous);
    }
    for i in (0..rows.len().saturating_sub(1)).rev() {
        values[i] = values[i] - values[i + 1] * ratio[i];
    }
    values
}

/// Solves a tridiagonal system whose first and last unknowns are neighbours too: the system without
/// the two corner entries, corrected by a matrix of rank one (Sherman and Morrison 1950). At least
/// three rows.
fn solve_cyclic(rows: &[Row]) -> Vec<Point> {
    let n = rows.len();
    let (top, bottom) = (rows[0].left, rows[n - 1].right);
    let shift = -rows[0].diagonal;
    let mut open = rows.to_vec();
    open[0].diagonal -= shift;
    open[n - 1].diagonal -= top * bottom / shift;
    let values = solve(&open);
    for (i, row) in open.iter_mut().enumerate() {
        let u = if i == 0 {
            shift
        } else if i == n - 1 {
            bottom
        } else {
            0.0
        };
        row.value = Point::new(u, 0.0);
    }
    let correction = solve(&open);
    let weight = top / shift;
    let denominator = 1.0 + correction[0].r + weight * correction[n - 1].r;
    let factor = (values[0] + values[n - 1] * weight) * denominator.recip();
    values.iter().zip(correction).map(|(v, c)| *v - factor * c.r).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Segment;
    use proptest::prelude::*;

    const BOTH: [Spline; 2] = [Spline::Natural, Spline::CatmullRom];

    fn points(list: &[[f64; 2]]) -> Vec<Point> {
        list.iter().map(|p| Point::new(p[0], p[1])).collect()
    }

    fn vase() -> Vec<Point> {
        points(&[[1.0, 0.0], [1.6, 0.5], [2.0, 1.5], [1.2, 3.0], [0.9, 3.2], [1.3, 4.0]])
    }

    fn ring() -> Vec<Point> {
        points(&[[3.0, 0.0], [4.0, 1.0], [3.2, 2.5], [2.0, 1.5], [2.1, 0.2], [3.0, 0.0]])
    }

    /// First and second derivatives by chord length at both ends of a segment.
    fn derivatives(segment: &Segment) -> ([Point; 2], [Point; 2]) {
        let [a, b, c, d] = match *segment {
            Segment::Cubic(p) => p,
            Segment::Line([p, q]) => [p, p.lerp(q, 1.0 / 3.0), p.lerp(q, 2.0 / 3.0), q],
            _ => panic!("neither a cubic nor a line"),
        };
        let h = (d - a).length();
        let first = |p: Point, q: Point| (q - p) * (3.0 / h);
        let second = |p: Point, q: Point, r: Point| (p - q * 2.0 + r) * (6.0 / (h * h));
        ([first(a, b), first(c, d)], [second(a, b, c), second(b, c, d)])
    }

    fn joints(profile: &Profile) -> Vec<(Segment, Segment)> {
        let all: Vec<_> = profile.segments().copied().collect();
        let mut pairs: Vec<_> = all.windows(2).map(|w| (w[0], w[1])).collect();
        if profile.subpaths()[0].is_closed() {
            pairs.push((all[all.len() - 1], all[0]));
        }
        pairs
    }

    fn assert_smooth(profile: &Profile, curvature: bool) {
        for (before, after) in joints(profile) {
            let ((v, a), (w, b)) = (derivatives(&before), derivatives(&after));
            assert!((v[1] - w[0]).length() < 1e-13, "{before:?} {after:?}");
            assert!(!curvature || (a[1] - b[0]).length() < 1e-12, "{before:?} {after:?}");
        }
    }

    #[test]
    fn passes_through_the_points() {
        for spline in [Spline::Polyline, Spline::Natural, Spline::CatmullRom] {
            for list in [vase(), ring()] {
                let profile = Profile::through_points(&list, spline).unwrap();
                let ends: Vec<_> = profile.segments().map(Segment::end).collect();
                assert_eq!(ends, list[1..]);
                assert_eq!(profile.subpaths()[0].start(), list[0]);
                assert_eq!(profile.subpaths()[0].is_closed(), list[0] == list[list.len() - 1]);
            }
        }
    }

    #[test]
    fn natural_spline_has_continuous_curvature_and_none_at_its_ends() {
        let profile = Profile::through_points(&vase(), Spline::Natural).unwrap();
        assert_smooth(&profile, true);
        let all: Vec<_> = profile.segments().collect();
        assert!(derivatives(all[0]).1[0].length() < 1e-13);
        assert!(derivatives(all[all.len() - 1]).1[1].length() < 1e-13);
        assert_smooth(&Profile::through_points(&ring(), Spline::Natural).unwrap(), true);
    }

    #[test]
    fn catmull_rom_tangents_are_parallel_to_the_neighbours() {
        for list in [vase(), ring()] {
            let profile = Profile::through_points(&list, Spline::CatmullRom).unwrap();
            assert_smooth(&profile, false);
            for (before, after) in joints(&profile) {
                let tangent = derivatives(&after).0[0];
                let across = after.end() - before.start();
                let cross = tangent.r * across.z - tangent.z * across.r;
                assert!(cross.abs() < 1e-13, "{before:?} {after:?}");
            }
        }
    }

    #[test]
    fn catmull_rom_ends_in_parabolas() {
        let profile = Profile::through_points(&vase(), Spline::CatmullRom).unwrap();
        let ([_, _], [a, b]) = derivatives(profile.segments().next().unwrap());
        assert!((a - b).length() < 1e-13);
    }

    #[test]
    fn a_line_stays_a_line() {
        let list = points(&[[1.0, 0.0], [1.5, 1.0], [1.75, 1.5], [3.0, 4.0]]);
        for spline in BOTH {
            let profile = Profile::through_points(&list, spline).unwrap();
            for segment in profile.segments() {
                for i in 0..=8 {
                    let p = segment.point(f64::from(i) / 8.0);
                    assert!((p.z - 2.0 * (p.r - 1.0)).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn periodic_square_is_symmetric() {
        let list = points(&[[2.0, 0.0], [3.0, 1.0], [2.0, 2.0], [1.0, 1.0], [2.0, 0.0]]);
        for spline in BOTH {
            let profile = Profile::through_points(&list, spline).unwrap();
            let reach: Vec<_> = profile
                .segments()
                .map(|s| (s.point(0.5) - Point::new(2.0, 1.0)).length())
                .collect();
            assert!(reach.iter().all(|r| (r - reach[0]).abs() < 1e-15), "{reach:?}");
        }
    }

    #[test]
    fn a_repeated_point_is_a_corner() {
        let mut list = vase();
        list.insert(3, list[2]);
        for spline in BOTH {
            let whole = Profile::through_points(&list, spline).unwrap();
            let lower = Profile::through_points(&list[..3], spline).unwrap();
            let upper = Profile::through_points(&list[3..], spline).unwrap();
            let parts: Vec<_> = lower.segments().chain(upper.segments()).collect();
            assert_eq!(whole.segments().collect::<Vec<_>>(), parts);
        }
        let plain = Profile::through_points(&vase(), Spline::Polyline).unwrap();
        assert_eq!(Profile::through_points(&list, Spline::Polyline).unwrap(), plain);
    }

    #[test]
    fn a_closed_curve_with_one_corner_passes_its_seam_smoothly() {
        let mut list = ring();
        list.insert(3, list[2]);
        let corner = list[2];
        for spline in BOTH {
            let profile = Profile::through_points(&list, spline).unwrap();
            assert!(profile.subpaths()[0].is_closed());
            for (before, after) in joints(&profile) {
                let gap = (derivatives(&before).0[1] - derivatives(&after).0[0]).length();
                assert_eq!(gap > 1e-3, before.end() == corner, "{before:?} {after:?}");
            }
        }
        // A doubled seam is a corner like any other, at whichever end it is written.
        let ring = ring();
        let ends = [[&ring[..1], &ring].concat(), [&ring, &ring[..1]].concat()];
        for spline in BOTH {
            let [a, b] = ends.each_ref().map(|p| Profile::through_points(p, spline).unwrap());
            assert_eq!(a, b);
            let (before, after) = joints(&a)[ring.len() - 2];
            assert!((derivatives(&before).0[1] - derivatives(&after).0[0]).length() > 1e-3);
        }
    }

    #[test]
    fn short_lists() {
        let error = |list: &[[f64; 2]]| {
            Profile::through_points(&points(list), Spline::Natural).unwrap_err().kind
        };
        assert_eq!(error(&[]), ProfileErrorKind::TooFewPoints { found: 0 });
        assert_eq!(error(&[[1.0, 0.0]]), ProfileErrorKind::TooFewPoints { found: 1 });
        let point = Point::new(1.0, 2.0);
        assert_eq!(error(&[[1.0, 2.0], [1.0, 2.0]]), ProfileErrorKind::NoExtent { point });
        for spline in BOTH {
            let two = points(&[[1.0, 0.0], [2.0, 1.0]]);
            let line = Profile::through_points(&two, spline).unwrap();
            assert!(matches!(line.segments().next(), Some(Segment::Line(_))));
            let there_and_back = points(&[[1.0, 0.0], [2.0, 1.0], [1.0, 0.0]]);
            let profile = Profile::through_points(&there_and_back, spline).unwrap();
            assert_eq!(profile.segments().count(), 2);
        }
    }

    #[test]
    fn bad_points_are_named() {
        for spline in [Spline::Polyline, Spline::Natural, Spline::CatmullRom] {
            let mut list = vase();
            list[2].r = f64::NAN;
            let error = Profile::through_points(&list, spline).unwrap_err();
            assert!(matches!(error.kind, ProfileErrorKind::NotFinite { .. }), "{error}");
            list[2].r = 1e200;
            let error = Profile::through_points(&list, spline).unwrap_err();
            assert!(matches!(error.kind, ProfileErrorKind::Magnitude { .. }), "{error}");
        }
    }

    proptest! {
        #[test]
        fn natural_splines_are_smooth_at_any_spacing(
            steps in prop::collection::vec((0.01..10.0_f64, -3.0..3.0_f64), 2..20),
        ) {
            let mut list = vec![Point::new(100.0, 0.0)];
            for (dz, dr) in steps {
                let last = list[list.len() - 1];
                list.push(last + Point::new(dr, dz));
            }
            let profile = Profile::through_points(&list, Spline::Natural).unwrap();
            for (before, after) in joints(&profile) {
                let ((v, a), (w, b)) = (derivatives(&before), derivatives(&after));
                prop_assert!((v[1] - w[0]).length() < 1e-8);
                // Second derivatives of steps of 0.01 at r = 100 lose nine digits to cancellation.
                prop_assert!((a[1] - b[0]).length() < 1e-6 * (1.0 + a[1].length()));
            }
        }
    }
}
