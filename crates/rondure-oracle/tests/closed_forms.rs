//! Spheres, cones, cylinders and tori drawn as profiles, against their equations; parity; every
//! standard profile and random ones against the oracle. `rondure-oracle soak` runs the same for longer.

use rondure_oracle::{
    Random, Tally,
    profiles::{SOLIDS, STANDARD, standard},
    suites,
};

/// The promise: every t to 1e-12 of the size.
fn assert_exact(tally: &Tally) {
    tally.assert_clean();
    assert!(tally.worst_forward < 1e-12, "{tally}");
    assert!(tally.hits > tally.rays / 4, "{tally}");
}

#[test]
fn solids_agree_with_their_equations() {
    for (name, solid) in SOLIDS {
        let mut tally = Tally::default();
        suites::against_closed_form(name, solid, 100_000, &mut Random::new(11), &mut tally);
        assert_exact(&tally);
    }
}

#[test]
fn lines_cross_a_closed_goblet_an_even_number_of_times() {
    let mut tally = Tally::default();
    suites::parity(&standard("goblet"), 200_000, &mut Random::new(12), &mut tally);
    tally.assert_clean();
    assert!(tally.hits > tally.rays / 4);
}

#[test]
fn standard_profiles_agree_with_the_oracle() {
    for (name, _) in STANDARD {
        let mut tally = Tally::default();
        suites::against_oracle(&standard(name), 10_000, &mut Random::new(13), &mut tally);
        assert_exact(&tally);
    }
}

#[test]
fn random_profiles_agree_with_the_oracle() {
    let mut tally = Tally::default();
    suites::random_profiles(50_000, &mut Random::new(14), &mut tally);
    tally.assert_clean();
    assert!(tally.hits > tally.rays / 4);
}
