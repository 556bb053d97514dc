//! Solids cut at the height of one of their own vertices, pixel for pixel; `rondure-oracle cuts` does it
//! at all of them.

use rondure::Profile;
use rondure_oracle::{
    Random,
    cuts::{Cuts, EYES},
    profiles::{STANDARD, standard},
};

#[test]
fn every_pixel_of_the_standard_solids_is_right() {
    let mut cuts = Cuts::default();
    for (name, _) in STANDARD {
        cuts.cut(name, &standard(name).capped(), 6, &EYES[..1]);
    }
    println!("{cuts}");
    assert!(cuts.are_right(), "{cuts}");
    assert!(cuts.faces > 8_000 && cuts.unclear < cuts.pixels / 200, "{cuts}");
}

/// Level faces at the height of the cut, above it and below it, peaks that end there, and walls between.
#[test]
fn every_pixel_of_solids_with_level_faces_is_right() {
    let mut cuts = Cuts::default();
    for text in [
        "M 0 0 H 3 V 0.1 H 2 V 0.2 H 1 V 0.3 H 0",
        "M 0 0 H 1 V 1 H 3 V 2 H 1 V 3 H 0",
        "M 0 0 L 1 0.7 L 0 1.4 L 1 2.1 L 0 2.8",
        "M 1 0 L 2 0 L 2.5 1 L 2 2 L 1 2 L 0.5 1 Z M 3 1 H 4 V 2 H 3 Z",
    ] {
        cuts.cut(text, &Profile::from_path_data(text).unwrap(), usize::MAX, &EYES[1..]);
    }
    println!("{cuts}");
    assert!(cuts.are_right(), "{cuts}");
    assert!(cuts.faces > 30_000 && cuts.unclear < cuts.pixels / 100, "{cuts}");
}

#[test]
fn every_pixel_of_random_solids_is_right() {
    let (mut random, mut cuts) = (Random::new(91), Cuts::default());
    for _ in 0..4 {
        cuts.cut("random", &random.profile().capped(), 6, &EYES[..1]);
    }
    println!("{cuts}");
    assert!(cuts.are_right(), "{cuts}");
    assert!(cuts.faces > 1_000 && cuts.unclear < cuts.pixels / 100, "{cuts}");
}
