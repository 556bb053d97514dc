//! Random profiles and rays made of awkward numbers: neighbours in the last place of each other, of
//! vertices, of zero and of powers of two.

use proptest::{collection::vec, prelude::*, test_runner::RngSeed};
use rondure::{Profile, Ray, Surface, Vec3, profile::ProfileBuilder};
use rondure_oracle::{Oracle, Tally};

/// A coordinate: round numbers, their neighbours, tiny offsets, or anything.
fn coordinate() -> impl Strategy<Value = f64> {
    let round = prop_oneof![Just(0.0), Just(0.25), Just(0.5), Just(1.0), Just(0.1), Just(2.0)];
    let near = (round.clone(), -4..5_i64).prop_map(|(x, steps): (f64, i64)| {
        if x == 0.0 {
            steps.unsigned_abs() as f64 * f64::EPSILON
        } else {
            f64::from_bits(x.to_bits().wrapping_add_signed(steps))
        }
    });
    let tiny =
        (round.clone(), prop_oneof![Just(1e-17), Just(1e-12), Just(1e-8)]).prop_map(|(x, e)| x + e);
    prop_oneof![3 => round, 2 => near, 1 => tiny, 4 => 0.0..2.0]
}

fn signed() -> impl Strategy<Value = f64> {
    (coordinate(), any::<bool>()).prop_map(|(x, negative)| if negative { -x } else { x })
}

#[derive(Clone, Debug)]
enum Stroke {
    Line,
    Quadratic([f64; 2]),
    Cubic([f64; 4]),
    Arc([f64; 2], bool, bool),
}

fn stroke() -> impl Strategy<Value = (Stroke, f64, f64)> {
    let kind = prop_oneof![
        Just(Stroke::Line),
        (coordinate(), signed()).prop_map(|(r, z)| Stroke::Quadratic([r, z])),
        (coordinate(), signed(), coordinate(), signed())
            .prop_map(|(a, b, c, d)| Stroke::Cubic([a, b, c, d])),
        ([0.1..2.0, 0.1..2.0], any::<bool>(), any::<bool>())
            .prop_map(|(radii, large, sweep)| Stroke::Arc(radii, large, sweep)),
    ];
    (kind, coordinate(), signed())
}

fn profile() -> impl Strategy<Value = Profile> {
    (coordinate(), signed(), vec(stroke(), 1..5), any::<bool>()).prop_filter_map(
        "a valid profile",
        |(r, z, strokes, close)| {
            let draw = |path: ProfileBuilder, (stroke, r, z): (Stroke, f64, f64)| match stroke {
                Stroke::Line => path.line_to(r, z),
                Stroke::Quadratic(c) => path.quad_to(c, r, z),
                Stroke::Cubic([a, b, c, d]) => path.cubic_to([a, b], [c, d], r, z),
                Stroke::Arc(radii, large, sweep) => path.arc_to(radii, 0.3, large, sweep, r, z),
            };
            let path = strokes.into_iter().fold(Profile::builder().move_to(r, z), draw);
            if close { path.close() } else { path }.build().ok()
        },
    )
}

fn ray() -> impl Strategy<Value = Ray> {
    let origin = [signed(), signed(), signed()];
    let direction = [signed(), signed(), signed()];
    (origin, direction, any::<bool>()).prop_filter_map("a direction", |(o, d, line)| {
        let [o, d] = [o, d].map(|[x, y, z]| Vec3::new(x, y, z));
        (d.max_abs() > 0.0).then(|| if line { Ray::line(o, d) } else { Ray::new(o, d) })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..Default::default() })]

    #[test]
    fn awkward_rays_at_awkward_profiles(profile in profile(), rays in vec(ray(), 8)) {
        let (surface, oracle) = (Surface::new(&profile), Oracle::new(&profile));
        let mut tally = Tally::default();
        for ray in &rays {
            tally.compare(&surface, &oracle, ray, profile.bounds_solid());
        }
        prop_assert!(tally.is_clean(), "{tally}");
    }
}
