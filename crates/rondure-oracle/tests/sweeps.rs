//! Partial sweeps, closed and open, and capped profiles.

use core::f64::consts::TAU;
use std::sync::Arc;

use rondure::{
    Affine, FillRule, Instance, Profile, Ray, Solid, Surface, Vec3,
    solid::{Csg, OpenSweep, Span, Sweep},
};
use rondure_oracle::{Oracle, Random, profiles::standard};

const NAMES: [&str; 4] = ["torus", "goblet", "pawn", "cone"];

const SWEEPS: [[f64; 2]; 8] = [
    [0.0, 90.0],
    [-30.0, 45.0],
    [10.0, 190.0],
    [0.0, 180.0],
    [90.0, 360.0],
    [123.0, 400.0],
    [-1.0, 358.0],
    [0.0, 360.0],
];

/// By how many degrees an angle lies behind the beginning of a sweep.
fn behind(from: f64, p: Vec3) -> f64 {
    ((p.y.atan2(p.x) / TAU * 360.0 - from) % 360.0 + 360.0) % 360.0
}

#[test]
fn a_swept_solid_is_the_whole_one_within_the_wedge() {
    let mut random = Random::new(81);
    for name in NAMES {
        let profile = standard(name);
        let solid = Arc::new(Solid::new(&profile, FillRule::NonZero).unwrap());
        let oracle = Oracle::new(&profile);
        let (center, size) = (oracle.center(), oracle.size());
        for [from, to] in SWEEPS {
            let sweep = Sweep::degrees(from, to).unwrap();
            let swept = Csg::turned(Arc::clone(&solid)).swept(&sweep).build().unwrap();
            let within = |p: Vec3| {
                let behind = behind(from, p);
                let close = [0.0, 360.0, to - from].iter().any(|a| (behind - a).abs() < 1e-9);
                (!close || to - from == 360.0).then_some(behind < to - from)
            };
            let mut inside = 0;
            for _ in 0..3000 {
                let p = center + random.cube() * (0.5 * size);
                let Some(within) = within(p) else { continue };
                assert_eq!(
                    swept.contains(p),
                    within && solid.contains(p),
                    "{name} {from} {to} {p:?}"
                );
                inside += usize::from(within);
            }
            assert!(inside > 100);
            let (mut spans, mut middles) = (Vec::<Span<_>>::new(), 0);
            for i in 0..1000 {
                let mut ray = random.line(center, size);
                if i % 4 == 0 {
                    // Through the axis, where the two faces meet.
                    let on_axis = Vec3::new(0.0, 0.0, center.z + random.within(-0.3, 0.3) * size);
                    ray.origin = on_axis - ray.direction * 3.0;
                }
                swept.spans(&ray, &mut spans);
                let stops = spans.iter().flat_map(|s| [s.enter.t, s.exit.t]).collect::<Vec<_>>();
                let ends = [-9.0 * size, 9.0 * size];
                let stops: Vec<f64> = [ends[0]].into_iter().chain(stops).chain([ends[1]]).collect();
                for (n, pair) in stops.windows(2).enumerate() {
                    let p = ray.at(0.5 * (pair[0] + pair[1]));
                    if (pair[1] - pair[0]) < 1e-6 || within(p).is_none() {
                        continue;
                    }
                    middles += 1;
                    let expected = within(p) == Some(true) && solid.contains(p);
                    assert_eq!(n % 2 == 1, expected, "{name} {from} {to} {ray:?} {pair:?}");
                }
                for span in &spans {
                    for face in [span.enter.wall.unwrap(), span.exit.wall.unwrap()] {
                        let at = swept.interaction(&ray, &face);
                        if face.leaf() > 0 {
                            // The first face looks back, the second one ahead.
                            let angle = if face.leaf() == 1 { from - 90.0 } else { to + 90.0 };
                            let (sin, cos) = angle.to_radians().sin_cos();
                            let off = (at.normal - Vec3::new(cos, sin, 0.0)).length();
                            assert!(off < 1e-14 && !face.flipped, "{name} {from} {to} {at:?}");
                        }
                    }
                }
            }
            assert!(middles > 1000, "{middles}");
        }
    }
}

#[test]
fn an_open_sweep_has_the_hits_within_and_no_others() {
    let mut random = Random::new(82);
    for name in ["vase", "torus"] {
        let profile = standard(name);
        let surface = Arc::new(Surface::new(&profile));
        let oracle = Oracle::new(&profile);
        let map = Affine::rotate(Vec3::new(0.2, 0.7, -0.4), 1.2).after(&Affine::translate(Vec3::X));
        let back = map.inverse_rows().unwrap();
        for [from, to] in SWEEPS {
            let instance = Instance::new(Arc::clone(&surface), map).unwrap();
            let sweep = Sweep::radians(from.to_radians(), to.to_radians()).unwrap();
            let open = OpenSweep::new(instance.clone(), &sweep).unwrap();
            let (mut all, mut some) = (Vec::new(), Vec::new());
            for _ in 0..1000 {
                let own = random.line(oracle.center(), oracle.size());
                let ray = Ray::new(map.point(own.origin), map.vector(own.direction));
                instance.all(&ray, &mut all);
                open.all(&ray, &mut some);
                all.retain(|hit| {
                    let p = instance.interaction(&ray, hit).point - map.translation;
                    let own = Vec3::new(back[0].dot(p), back[1].dot(p), back[2].dot(p));
                    behind(from, own) < to - from
                });
                assert_eq!(some, all, "{name} {from} {to} {ray:?}");
                assert_eq!(open.closest(&ray), all.first().copied());
                assert_eq!(open.any(&ray), !all.is_empty());
            }
        }
    }
}

#[test]
fn caps_close_a_vase() {
    let open = Profile::from_path_data("M 1 0 C 2 1 0.5 2 1.5 3").unwrap();
    assert!(Solid::new(&open, FillRule::NonZero).is_err());
    let solid = Solid::new(&open.capped(), FillRule::NonZero).unwrap();
    let mut spans = Vec::new();
    solid.spans(&Ray::new(Vec3::new(0.3, 0.2, -2.0), Vec3::Z), &mut spans);
    assert_eq!([spans[0].enter.t, spans[0].exit.t], [2.0, 5.0]);
    let cap = spans[0].exit.wall.unwrap();
    assert_eq!(solid.surface().segment(&cap.hit), 2);
    assert!(
        solid.contains(Vec3::new(0.0, 0.0, 1e-9)) && !solid.contains(Vec3::new(0.0, 0.0, -1e-9))
    );
}

#[test]
fn sweeps_that_are_none_are_refused() {
    for [from, to] in [[10.0, 10.0], [90.0, 0.0], [0.0, 361.0], [0.0, f64::NAN]] {
        assert!(Sweep::degrees(from, to).is_err());
    }
    assert_eq!(
        Sweep::degrees(90.0, 0.0).unwrap_err().to_string(),
        "the sweep runs from 90 to 0; the second angle must be larger than the first, by at most a \
         whole turn, 360"
    );
}
