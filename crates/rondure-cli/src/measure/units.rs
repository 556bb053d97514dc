//! Units of length, of liquid and of mass.

use std::fmt;

use clap::ValueEnum;
use rondure_scene::Unit;

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum LengthUnit {
    /// Millimetres
    Mm,
    /// Centimetres
    Cm,
    /// Metres
    M,
    /// Inches
    In,
}

impl LengthUnit {
    /// The same unit, if a drawing's is one of these.
    pub(super) fn of(unit: Unit) -> Option<Self> {
        match unit {
            Unit::Mm => Some(Self::Mm),
            Unit::Cm => Some(Self::Cm),
            Unit::M => Some(Self::M),
            Unit::In => Some(Self::In),
            Unit::Px | Unit::Pt | Unit::Pc => None,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Cm => "cm",
            Self::M => "m",
            Self::In => "in",
        }
    }

    /// The millilitres in a cube of this unit.
    fn millilitres(self) -> f64 {
        match self {
            Self::Mm => 1e-3,
            Self::Cm => 1.0,
            Self::M => 1e6,
            Self::In => 2.54 * 2.54 * 2.54,
        }
    }
}

/// The unit of length, if it is known, and the density as it was given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Units {
    pub(super) length: Option<LengthUnit>,
    pub(super) density: Option<f64>,
}

impl Units {
    /// The mass of a cubic unit: in grams if the unit is known, as a cubic centimetre is a
    /// millilitre; 1 if no density was given.
    pub(super) fn in_cubic_units(&self) -> f64 {
        let density = self.density.unwrap_or(1.0);
        match (self.density, self.length) {
            (Some(_), Some(unit)) => density * unit.millilitres(),
            _ => density,
        }
    }

    /// A quantity with the unit of length to a power from 1 to 5.
    pub(super) fn powered(&self, x: f64, power: usize) -> String {
        let power = ["", "", "²", "³", "⁴", "⁵"][power];
        match self.length {
            Some(unit) => format!("{} {}{power}", digits(x), unit.name()),
            None => digits(x),
        }
    }

    /// A quantity of liquid.
    pub(super) fn liquid(&self, volume: f64) -> String {
        match self.length.map(|unit| volume * unit.millilitres()) {
            Some(ml) if ml < 1000.0 => format!("{} ml", digits(ml)),
            Some(ml) => format!("{} l", digits(1e-3 * ml)),
            None => digits(volume),
        }
    }

    /// The mass of a volume, if a density was given.
    pub(super) fn mass(&self, volume: f64) -> Option<String> {
        self.density?;
        let mass = self.in_cubic_units() * volume;
        Some(match self.length {
            Some(_) if mass < 1000.0 => format!("{} g", digits(mass)),
            Some(_) => format!("{} kg", digits(1e-3 * mass)),
            None => digits(mass),
        })
    }

    /// A moment of inertia, given for density 1.
    pub(super) fn inertia(&self, moment: f64) -> String {
        let moment = self.in_cubic_units() * moment;
        match (self.density, self.length) {
            (Some(_), Some(unit)) => format!("{} g {}²", digits(moment), unit.name()),
            _ => self.powered(moment, 5),
        }
    }
}

/// Eight significant digits, or as many as there are.
pub(super) fn digits(x: f64) -> String {
    const DIGITS: i32 = 8;
    if x == 0.0 {
        return "0".into();
    }
    let scientific = format!("{x:.*e}", DIGITS as usize - 1);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    if (-4..DIGITS).contains(&exponent) {
        trimmed(&format!("{x:.*}", (DIGITS - 1 - exponent) as usize))
    } else {
        format!("{}e{exponent}", trimmed(mantissa))
    }
}

/// A volume as it was typed: a number, and millilitres if it had a unit of its own.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Volume {
    text: String,
    number: f64,
    millilitres: Option<f64>,
}

impl Volume {
    /// In cubes of the unit of length; `None` if that is not known but needed.
    pub(super) fn in_units(&self, units: &Units) -> Option<f64> {
        match self.millilitres {
            None => Some(self.number),
            Some(ml) => Some(ml / units.length?.millilitres()),
        }
    }
}

impl fmt::Display for Volume {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Reads a volume: `1.5`, `250ml`, `25cl`, `0.25l`.
pub(super) fn volume(text: &str) -> Result<Volume, String> {
    let suffixes = [("ml", 1.0), ("cl", 10.0), ("l", 1000.0), ("L", 1000.0)];
    let found = suffixes.into_iter().find_map(|(s, ml)| Some((text.strip_suffix(s)?, ml)));
    let number = found.map_or(text, |(number, _)| number).trim_end();
    match number.parse::<f64>() {
        Ok(number) if number.is_finite() && number >= 0.0 => {
            let millilitres = found.map(|(_, ml)| number * ml);
            Ok(Volume { text: text.into(), number, millilitres })
        }
        _ => Err("expected a number that is not negative, alone or with ml, cl or l".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_digits_are_shown() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (-2.5, "-2.5"),
            (std::f64::consts::PI * 1e3, "3141.5927"),
            (0.1 + 0.2, "0.3"),
            (99_999_999.9, "1e8"),
            (12_345_678.4, "12345678"),
            (1.0e-4, "0.0001"),
            (1.234_567_891e-7, "1.2345679e-7"),
            (1e300, "1e300"),
        ] {
            assert_eq!(digits(x), text);
        }
    }

    #[test]
    fn volumes_are_read_with_their_units() {
        let cm = Units { length: Some(LengthUnit::Cm), density: None };
        let mm = Units { length: Some(LengthUnit::Mm), density: None };
        let none = Units { length: None, density: None };
        for (text, cubic_cm) in [("1.5", 1.5), ("250ml", 250.0), ("25 cl", 250.0), ("0.25l", 250.0)]
        {
            assert_eq!(volume(text).unwrap().in_units(&cm), Some(cubic_cm), "{text}");
        }
        assert_eq!(volume("2ml").unwrap().in_units(&mm), Some(2000.0));
        assert_eq!(volume("2ml").unwrap().in_units(&none), None);
        for text in ["", "l", "-1", "nan", "inf", "2 gal", "1e999"] {
            assert!(volume(text).is_err(), "{text}");
        }
    }
}
