//! Linear colour, three channels that light adds up in and surfaces multiply.

use core::ops::{Add, AddAssign, Div, Mul};

use rondure_scene::Color;

/// Linear red, green and blue (Rec. 709 primaries).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Rgb {
    pub(crate) r: f64,
    pub(crate) g: f64,
    pub(crate) b: f64,
}

impl Rgb {
    pub(crate) const BLACK: Self = Self::splat(0.0);
    pub(crate) const WHITE: Self = Self::splat(1.0);

    #[inline]
    pub(crate) const fn splat(v: f64) -> Self {
        Self { r: v, g: v, b: v }
    }

    #[inline]
    pub(crate) fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self { r: f(self.r), g: f(self.g), b: f(self.b) }
    }

    /// The largest channel.
    #[inline]
    pub(crate) fn max_channel(self) -> f64 {
        self.r.max(self.g).max(self.b)
    }

    /// How bright it looks (Rec. 709).
    #[inline]
    pub(crate) fn luminance(self) -> f64 {
        0.2126 * self.r + 0.7152 * self.g + 0.0722 * self.b
    }

    #[inline]
    pub(crate) fn is_black(self) -> bool {
        self == Self::BLACK
    }

    /// Whether every channel is finite and not negative: an amount of light.
    #[inline]
    pub(crate) fn is_light(self) -> bool {
        let ok = |v: f64| v >= 0.0 && v.is_finite();
        ok(self.r) && ok(self.g) && ok(self.b)
    }

    /// `self` for t = 0, `other` for t = 1.
    #[inline]
    pub(crate) fn mix(self, other: Self, t: f64) -> Self {
        self * (1.0 - t) + other * t
    }
}

impl From<Color> for Rgb {
    #[inline]
    fn from([r, g, b]: Color) -> Self {
        Self { r, g, b }
    }
}

impl Add for Rgb {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self { r: self.r + o.r, g: self.g + o.g, b: self.b + o.b }
    }
}

impl AddAssign for Rgb {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Mul for Rgb {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self { r: self.r * o.r, g: self.g * o.g, b: self.b * o.b }
    }
}

impl Mul<f64> for Rgb {
    type Output = Self;
    #[inline]
    fn mul(self, f: f64) -> Self {
        self.map(|v| v * f)
    }
}

impl Div<f64> for Rgb {
    type Output = Self;
    #[inline]
    fn div(self, f: f64) -> Self {
        self.map(|v| v / f)
    }
}
