//! Intersection intervals (paper, section 3.2), carried in the ray parameter.
//!
//! A ray is inside a convex wall during one interval. What lies inside the outer wall and not inside
//! the inner one is therefore nothing, one interval, or two.

/// None, one or two intervals, in order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Intervals {
    parts: [[f64; 2]; 2],
    len: usize,
}

impl Intervals {
    /// The part of a stretch within the outer and not within the inner interval. Ends that are NaN
    /// do not count as bounds.
    #[inline]
    pub(crate) fn between(
        [lo, hi]: [f64; 2],
        outer: Option<[f64; 2]>,
        inner: Option<[f64; 2]>,
    ) -> Self {
        let mut intervals = Self::default();
        let Some([enter, leave]) = outer else { return intervals };
        let (lo, hi) = (lo.max(enter), hi.min(leave));
        match inner {
            Some([from, to]) if from < hi && lo < to => {
                intervals.push(lo, from);
                intervals.push(to, hi);
            }
            _ => intervals.push(lo, hi),
        }
        intervals
    }

    #[inline]
    fn push(&mut self, lo: f64, hi: f64) {
        if lo <= hi {
            self.parts[self.len] = [lo, hi];
            self.len += 1;
        }
    }

    pub(crate) fn iter(&self) -> core::slice::Iter<'_, [f64; 2]> {
        self.parts[..self.len].iter()
    }
}

/// Where a t^2 + 2 b t + c <= 0, with a >= 0: between the two roots.
///
/// The roots are those of a polynomial whose coefficients differ from the given ones by a few units
/// in the last place.
#[inline]
pub(crate) fn sublevel(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    if a == 0.0 {
        let t = -0.5 * c / b;
        return match b {
            _ if b > 0.0 => Some([f64::NEG_INFINITY, t]),
            _ if b < 0.0 => Some([t, f64::INFINITY]),
            _ => (c <= 0.0).then_some([f64::NEG_INFINITY, f64::INFINITY]),
        };
    }
    roots(a, b, c, b * b - a * c)
}

/// The roots of a t^2 + 2 b t + c with the given discriminant, b^2 - a c, in order for a > 0; `None`
/// if it is negative.
#[inline]
pub(crate) fn roots(a: f64, b: f64, c: f64, discriminant: f64) -> Option<[f64; 2]> {
    if discriminant < 0.0 {
        return None;
    }
    let q = -(b + discriminant.sqrt().copysign(b));
    if q == 0.0 {
        return Some([0.0; 2]);
    }
    let (t0, t1) = (q / a, c / q);
    Some(if b >= 0.0 { [t0, t1] } else { [t1, t0] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn none_one_and_two() {
        let parts = |outer, inner| {
            Intervals::between([0.0, 10.0], outer, inner).iter().copied().collect::<Vec<_>>()
        };
        assert!(parts(None, None).is_empty());
        assert!(parts(Some([11.0, 12.0]), None).is_empty());
        assert!(parts(Some([1.0, 9.0]), Some([-1.0, 11.0])).is_empty());
        assert_eq!(parts(Some([-1.0, 9.0]), None), [[0.0, 9.0]]);
        assert_eq!(parts(Some([1.0, 9.0]), Some([-1.0, 5.0])), [[5.0, 9.0]]);
        assert_eq!(parts(Some([1.0, 9.0]), Some([4.0, 5.0])), [[1.0, 4.0], [5.0, 9.0]]);
        assert_eq!(parts(Some([3.0, 3.0]), None), [[3.0, 3.0]]);
    }

    #[test]
    fn sublevels_are_between_the_roots() {
        assert_eq!(sublevel(1.0, -2.0, 3.0), Some([1.0, 3.0]));
        assert_eq!(sublevel(1.0, 2.0, 3.0), Some([-3.0, -1.0]));
        assert_eq!(sublevel(1.0, 0.0, -4.0), Some([-2.0, 2.0]));
        assert_eq!(sublevel(1.0, 0.0, 0.0), Some([0.0, 0.0]));
        assert_eq!(sublevel(1.0, 0.0, 1.0), None);
        assert_eq!(sublevel(0.0, 1.0, -4.0), Some([f64::NEG_INFINITY, 2.0]));
        assert_eq!(sublevel(0.0, -1.0, 4.0), Some([2.0, f64::INFINITY]));
        assert_eq!(sublevel(0.0, 0.0, 1.0), None);
    }
}
