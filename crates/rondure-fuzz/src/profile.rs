//! Profiles in all their formats: a good one is within its promises, a bad one gets a report.

use rondure::{
    Profile, Spline, Surface,
    profile::{Rim, Side, Thickness},
};
use rondure_scene::{ProfileFormat, ProfileOptions, Unit, parse_profile};

use crate::check_report;

/// The first byte chooses format and options, the rest is the text.
pub fn profile(data: &[u8]) {
    let Some((&choice, rest)) = data.split_first() else { return };
    let Ok(text) = core::str::from_utf8(rest) else { return };
    let (format, options) = choose(choice);
    match parse_profile("fuzz", text, format, &options) {
        Ok(profile) => {
            check(&profile);
            let wall = options.thickness.is_some();
            assert!(!wall || profile.bounds_solid(), "an open wall: {profile:?}");
        }
        Err(report) => {
            assert!(report.errors() > 0, "refused without an error");
            check_report(&report);
        }
    }
}

fn choose(choice: u8) -> (ProfileFormat, ProfileOptions) {
    let bit = |n: u32| choice >> n & 1 == 1;
    let mut options = ProfileOptions { scale: bit(7).then_some(0.3), ..Default::default() };
    if choice & 3 == 1 {
        let side = [Side::Inward, Side::Outward, Side::Centered, Side::Inward]
            [usize::from(choice >> 2 & 3)];
        let rim = if bit(4) { Rim::Round } else { Rim::Flat };
        let thickness = if bit(5) { 0.02 } else { 0.3 };
        options.thickness = Some(Thickness { thickness, side, rim });
    }
    let format = match choice & 3 {
        0 | 1 => ProfileFormat::PathData,
        2 => {
            options.axis = bit(2).then_some(50.0);
            options.unit = bit(3).then_some(Unit::Mm);
            options.id = bit(4).then(|| "it".into());
            options.snap = bit(5).then_some(0.5);
            options.base = bit(6).then_some(9.0);
            ProfileFormat::Svg
        }
        _ => {
            options.spline = match choice >> 2 & 3 {
                0 => None,
                1 => Some(Spline::Natural),
                _ => Some(Spline::CatmullRom),
            };
            ProfileFormat::Csv
        }
    };
    (format, options)
}

/// What is promised of every profile, and of the surface that it sweeps.
fn check(profile: &Profile) {
    assert!(profile.segments().count() > 0, "a profile without segments");
    for subpath in profile.subpaths() {
        for pair in subpath.segments().windows(2) {
            assert_eq!(pair[0].end(), pair[1].start(), "a gap in {profile:?}");
        }
        if subpath.is_closed() {
            assert_eq!(subpath.start(), subpath.end(), "closed, but not shut: {profile:?}");
        }
    }
    for segment in profile.segments() {
        for end in [segment.start(), segment.end()] {
            assert!(end.is_finite() && end.r >= 0.0, "an end at {end:?}");
        }
    }
    assert!(profile.capped().bounds_solid(), "capped, but open: {profile:?}");
    let bounds = Surface::new(profile).bounds();
    assert!(bounds.min.is_finite() && bounds.max.is_finite(), "{bounds:?}");
}
