//! What vessels hold: brims, levels, rings round a punt, air under overhangs, siphons.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

use std::f64::consts::PI;

use rondure::Profile;
use rondure::measure::{Cavity, Measure, NoCavity, NoSolid};
use rondure::profile::PlaneMap;

fn measure(path: &str) -> Measure {
    Profile::from_path_data(path).unwrap().measure()
}

/// The path data of a file without its comments.
fn without_comments(text: &str) -> String {
    text.lines().map(|line| line.split('#').next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

fn cavity(path: &str) -> Cavity {
    measure(path).cavity.unwrap()
}

#[track_caller]
fn near(value: f64, exact: f64, relative: f64) {
    let error = (value - exact).abs();
    assert!(error <= relative * exact.abs(), "{value} for {exact}: off by {error:e}");
}

/// Levels and volumes must undo each other.
#[track_caller]
fn levels_and_volumes_agree(cavity: &Cavity) {
    let (bottom, brim) = (cavity.bottom(), cavity.brim());
    let mut last = 0.0;
    for i in 0..=200 {
        let z = if i == 200 { brim } else { bottom + (brim - bottom) * f64::from(i) / 200.0 };
        let volume = cavity.volume(z).unwrap();
        assert!(volume >= last, "{volume} at {z} after {last}");
        last = volume;
        let level = cavity.level(volume).unwrap();
        let again = cavity.volume(level).unwrap();
        assert!((again - volume).abs() <= cavity.error(), "{volume} at {z}, {again} at {level}");
    }
    assert_eq!(last, cavity.capacity());
    assert_eq!(cavity.volume(bottom - 1.0), Some(0.0));
    assert_eq!(cavity.volume(brim + 1e-9), None);
    assert_eq!(cavity.volume(f64::NAN), None);
    assert_eq!(cavity.level(0.0), Some(bottom));
    assert_eq!(cavity.level(cavity.capacity()), Some(brim));
    assert_eq!(cavity.level(cavity.capacity() * 1.000_001), None);
    assert_eq!(cavity.level(-1e-9), None);
    assert_eq!(cavity.level(f64::NAN), None);
}

#[test]
fn a_beaker_of_no_thickness() {
    let beaker = cavity("M 0 0 L 1 0 L 1 2");
    assert_eq!((beaker.bottom(), beaker.brim(), beaker.trapped()), (0.0, 2.0, 0.0));
    near(beaker.capacity(), 2.0 * PI, 1e-15);
    near(beaker.volume(0.3).unwrap(), 0.3 * PI, 1e-15);
    near(beaker.level(PI).unwrap(), 1.0, 1e-15);
    levels_and_volumes_agree(&beaker);
}

#[test]
fn a_bowl_of_a_hemisphere() {
    let bowl = cavity("M 0 0 A 1 1 0 0 1 1 1");
    for i in 1..=100 {
        let h = f64::from(i) / 100.0;
        let volume = PI * h * h * (3.0 - h) / 3.0;
        near(bowl.volume(h).unwrap(), volume, 1e-14);
        near(bowl.level(volume.min(bowl.capacity())).unwrap(), h, 1e-14);
    }
    levels_and_volumes_agree(&bowl);
}

#[test]
fn a_flask_wider_than_its_mouth() {
    // A sphere of radius 1 up to the height 1.8, where its radius is 0.6.
    let flask = cavity("M 0 0 A 1 1 0 0 1 0.6 1.8");
    assert_eq!(flask.brim(), 1.8);
    near(flask.capacity(), PI * 1.8 * 1.8 * 0.4, 1e-14);
    levels_and_volumes_agree(&flask);
}

#[test]
fn a_paraboloid_fills_with_the_square_of_the_height() {
    let dish = cavity("M 0 0 Q 1 0 2 4");
    for h in [1e-9, 1e-3, 0.7, 3.9] {
        let error = (dish.volume(h).unwrap() - 0.5 * PI * h * h).abs();
        // A level is as good as its rounding in the middle of the dish, whose surface is this large.
        assert!(error <= 1e-15 * (PI * h), "{h}: {error:e}");
    }
    near(dish.level(0.5 * PI).unwrap(), 1.0, 1e-14);
}

#[test]
fn liquid_stands_round_a_punt() {
    // A cone of height 1 in the bottom of a cylinder.
    let bottle = cavity("M 0 1 L 1 0 L 1 3");
    assert_eq!((bottle.bottom(), bottle.brim()), (0.0, 3.0));
    for h in [0.01_f64, 0.5, 1.0] {
        // pi ∫ 1 - (1 - z)^2 dz
        near(bottle.volume(h).unwrap(), PI * (h * h - h.powi(3) / 3.0), 1e-14);
    }
    near(bottle.capacity(), PI * (2.0 + 2.0 / 3.0), 1e-14);
    levels_and_volumes_agree(&bottle);
}

#[test]
fn a_vessel_with_walls_holds_what_is_inside() {
    // A foot ring with a hollow below, a bowl above, and a lip that is rounded.
    let path =
        "M 0 0.4 L 0.8 0.4 L 0.8 0 L 1 0 L 1 0.5 L 2 1 L 2 3 A 0.1 0.1 0 0 1 1.8 3 L 1.8 1 L 0 1";
    let vessel = cavity(path);
    assert_eq!((vessel.bottom(), vessel.brim(), vessel.trapped()), (1.0, 3.1, 0.0));
    // The lip is half a circle: pi ∫ (1.9 - sqrt(0.01 - x^2))^2 dx from 0 to 0.1.
    let lip = PI * (0.361 - 3.8 * PI * 0.01 / 4.0 + 0.001 - 0.001 / 3.0);
    near(vessel.capacity(), PI * 3.24 * 2.0 + lip, 1e-14);
    levels_and_volumes_agree(&vessel);
    // Upside down the foot ring is the vessel.
    let flipped = Profile::from_path_data(path).unwrap().mapped(&PlaneMap::scale(1.0, -1.0));
    let foot = flipped.unwrap().measure().cavity.unwrap();
    assert_eq!((foot.bottom(), foot.brim()), (-0.4, 0.0));
    near(foot.capacity(), PI * 0.64 * 0.4, 1e-14);
}

#[test]
fn air_stays_under_an_overhang() {
    // An inkwell: its mouth is a tube that reaches down to half the height.
    let inkwell = cavity("M 0 0 L 2 0 L 2 2 L 1 2 L 1 1");
    near(inkwell.capacity(), 5.0 * PI, 1e-15);
    near(inkwell.trapped(), 3.0 * PI, 1e-15);
    near(inkwell.volume(1.0).unwrap(), 4.0 * PI, 1e-15);
    near(inkwell.volume(1.5).unwrap(), 4.5 * PI, 1e-15);
    levels_and_volumes_agree(&inkwell);
    // A roof with two humps, of which the inner one opens into the tube at z = 4.
    let humps = cavity("M 0 0 L 4 0 L 4 5 L 1 5 L 1 4 M 3 3 L 3 5");
    near(humps.trapped(), PI * ((16.0 - 9.0) * 2.0 + (9.0 - 1.0)), 1e-15);
    near(humps.capacity(), PI * (16.0 * 3.0 + 9.0 + 1.0), 1e-15);
    // A partition that hangs free: the air behind it leaves over its top.
    let partition = cavity("M 0 0 L 4 0 L 4 5 L 1 5 L 1 3 M 3 1 L 3 3");
    near(partition.trapped(), PI * 15.0 * 2.0, 1e-15);
    near(partition.capacity(), PI * (16.0 * 3.0 + 2.0), 1e-15);
}

#[test]
fn a_siphon_empties_at_its_crest() {
    // A bowl of radius 3 whose skirt hangs into a channel that rises to 3 and leads down outside.
    let path = "M 0 0 L 3.5 0 L 3.5 3 M 3 0.5 L 3 5 L 4 5 L 4 -1";
    let cup = cavity(path);
    assert_eq!((cup.bottom(), cup.brim(), cup.trapped()), (0.0, 3.0, 0.0));
    near(cup.capacity(), PI * 3.5 * 3.5 * 3.0, 1e-14);
}

#[test]
fn hollows_that_join_fill_to_one_level() {
    // A moat of radii 1 to 2 round a well of radius 1, parted by a wall up to 1.
    let cup = cavity("M 0 0 L 1 0 L 1 1 M 1 0 L 2 0 L 2 3");
    near(cup.volume(0.5).unwrap(), PI * 2.0, 1e-15);
    assert_eq!(cup.brim(), 3.0);
    near(cup.capacity(), PI * 12.0, 1e-15);
}

#[test]
fn what_holds_nothing_says_why() {
    for (path, reason) in [
        ("M 0 -1 A 1 1 0 0 1 0 1", NoCavity::RunsOff { z: 1.0 }),
        ("M 0 0 L 1 0 L 1 2 L 0 2 Z", NoCavity::RunsOff { z: 2.0 }),
        ("M 0 -2 A 2 2 0 0 1 0 2 M 0 -1 A 1 1 0 0 1 0 1", NoCavity::RunsOff { z: 2.0 }),
        ("M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z", NoCavity::Drains { bore: 1.0 }),
        ("M 1 0 L 2 3", NoCavity::Drains { bore: 1.0 }),
        ("M 1e-9 0 L 1 0 L 1 3", NoCavity::Drains { bore: 1e-9 }),
        // A bell.
        ("M 0 2 L 1 2 L 1 0", NoCavity::RunsOff { z: 2.0 }),
        // A plate, quite flat.
        ("M 0 2 L 1 2", NoCavity::RunsOff { z: 2.0 }),
    ] {
        assert_eq!(measure(path).cavity.unwrap_err(), reason, "{path}");
    }
}

#[test]
fn the_lowest_of_two_rims_is_the_brim() {
    // A beaker in a beaker, the inner one higher, and lower.
    near(cavity("M 0 0 L 1 0 L 1 3 M 0 -1 L 2 -1 L 2 2").capacity(), 3.0 * PI, 1e-15);
    let both = cavity("M 0 0 L 1 0 L 1 2 M 0 -1 L 2 -1 L 2 3");
    assert_eq!(both.brim(), 3.0);
    // All of the outer one but the sheet; the outside of the inner one's bottom is wet, too.
    near(both.capacity(), 16.0 * PI, 1e-15);
}

#[test]
fn profiles_in_use_hold_something() {
    for path in [
        include_str!("../../../profiles/goblet.path"),
        include_str!("../../../profiles/vase.path"),
        include_str!("../../../scenes/profiles/bottle.path"),
        include_str!("../../../scenes/profiles/tumbler.path"),
        include_str!("../../../scenes/profiles/wine-glass.path"),
    ] {
        let cavity = cavity(&without_comments(path));
        assert_eq!(cavity.trapped(), 0.0);
        assert!(cavity.error() < 1e-9 * cavity.capacity());
        levels_and_volumes_agree(&cavity);
        // The cylinder layers between many levels add up to the capacity.
        let (bottom, brim) = (cavity.bottom(), cavity.brim());
        let level = |i: u32| bottom + (brim - bottom) * f64::from(i) / 1000.0;
        let steps = (1..1000)
            .map(|i| cavity.volume(level(i)).unwrap() - cavity.volume(level(i - 1)).unwrap());
        near(
            steps.sum::<f64>() + cavity.capacity() - cavity.volume(level(999)).unwrap(),
            cavity.capacity(),
            1e-12,
        );
    }
    // 0.75 l up to the neck, and a little more to the mouth.
    let bottle = include_str!("../../../scenes/profiles/bottle.path");
    let bottle = cavity(&without_comments(bottle));
    assert!((700.0..900.0).contains(&bottle.capacity()), "{}", bottle.capacity());
}

#[test]
fn crossings_are_told_and_contacts_are_not() {
    for path in [
        // A bow tie, with its crossing at no corner, and at corners of other subpaths' heights.
        "M 1 0 L 3 2 L 1 2 L 3 0 Z",
        "M 1 0 L 3 2 L 1 2 L 3 0 Z M 5 1 L 6 1 L 6 3 Z",
        // A loop in a cubic.
        "M 1 0 C 6 2 -1 2 3 0 L 3 -1 L 1 -1 Z",
        "M 1 0 C 6 2 -1 2 3 0",
        // Two disks that overlap, along the axis and across it.
        "M 0 0 L 2 0 L 2 2 L 0 2 M 0 1 L 1 1 L 1 3 L 0 3",
        "M 1 0 L 3 0 L 3 2 L 1 2 Z M 2 1 L 4 1 L 4 3 L 2 3 Z",
        // Through a flat top.
        "M 0 0 L 3 0 L 3 2 L 1 2 L 1 3 L 2 3 L 2 1 L 0 1",
        // Two curves that cross twice between their ends.
        "M 1 0 Q 2 1 1 2 L 0 2 L 0 0 Z M 1.4 0 L 1.4 2 L 3 2 L 3 0 Z",
    ] {
        let measure = measure(path);
        assert!(matches!(measure.cavity, Err(NoCavity::Crossing { .. })), "{path}");
        assert!(matches!(measure.solid, Err(NoSolid::Crossing { .. })), "{path}");
        assert!(measure.length > 0.0 && measure.area > 0.0);
    }
    let near = |path: &str| match measure(path).solid {
        Err(NoSolid::Crossing { near }) => near,
        other => panic!("{other:?}"),
    };
    let tie = near("M 1 0 L 3 2 L 1 2 L 3 0 Z");
    assert!((tie.r - 2.0).abs() + (tie.z - 1.0).abs() < 1e-13, "{tie:?}");
    let pair = near("M 1 0 Q 2 1 1 2 L 0 2 L 0 0 Z M 1.4 0 L 1.4 2 L 3 2 L 3 0 Z");
    assert!((pair.r - 1.4).abs() < 1e-13, "{pair:?}");
    for (path, volume) in [
        // Tori that touch.
        (
            "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z M 5 0 A 1 1 0 0 1 3 0 A 1 1 0 0 1 5 0 Z",
            2.0 * PI * PI * 6.0,
        ),
        // Cylinders that stand on each other, and one beside them.
        (
            "M 0 0 L 2 0 L 2 1 L 0 1 Z M 0 1 L 1 1 L 1 2 L 0 2 Z M 2 0 L 3 0 L 3 1 L 2 1 Z",
            PI * (4.0 + 1.0 + 5.0),
        ),
        // A square on its corner, touched from within.
        ("M 1 0 L 2 1 L 1 2 L 0 1 Z M 1.5 0.5 L 1.5 1.5 L 0.5 1 Z", {
            let outer = 2.0 * 2.0 * PI * 1.0;
            outer - 0.5 * 2.0 * PI * (3.5 / 3.0)
        }),
    ] {
        let found = measure(path).solid.unwrap().volume;
        assert!((found - volume).abs() <= 1e-14 * volume, "{path}: {found} for {volume}");
    }
}

#[test]
fn open_profiles_have_no_volume() {
    let measure = measure("M 0 0 L 1 0 L 1 2");
    assert!(matches!(measure.solid, Err(NoSolid::Open { subpath: 0, .. })));
    near(measure.area, PI + 4.0 * PI, 1e-15);
    near(measure.length, 3.0, 1e-15);
}
