//! Units of length, as CSS defines them: 96 px are an inch.

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// CSS pixels.
    Px,
    /// Points: 72 are an inch.
    Pt,
    /// Picas: 6 are an inch.
    Pc,
    /// Millimetres.
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
    /// Inches.
    In,
}

impl Unit {
    /// All units by their names.
    pub const NAMES: [(&str, Self); 7] = [
        ("px", Self::Px),
        ("pt", Self::Pt),
        ("pc", Self::Pc),
        ("mm", Self::Mm),
        ("cm", Self::Cm),
        ("m", Self::M),
        ("in", Self::In),
    ];

    /// The unit with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, unit)| *unit)
    }

    /// The unit in CSS pixels.
    pub fn in_px(self) -> f64 {
        match self {
            Self::Px => 1.0,
            Self::Pt => 96.0 / 72.0,
            Self::Pc => 16.0,
            Self::Mm => 96.0 / 25.4,
            Self::Cm => 96.0 / 2.54,
            Self::M => 9600.0 / 2.54,
            Self::In => 96.0,
        }
    }
}
