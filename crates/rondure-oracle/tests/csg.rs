//! Solids made of others: the laws of sets, faces that coincide, cuts, and what is told about a face.

use std::sync::Arc;

use rondure::{
    Affine, Bounds, FillRule, Profile, Ray, Solid, Vec3,
    solid::{Compound, Csg, CsgError, Face, Span},
};
use rondure_oracle::{
    Random,
    laws::Laws,
    profiles::STANDARD,
    solids::{random_ray, random_solid, turned},
};

fn spans(compound: &Compound, ray: &Ray) -> Vec<Span<Face>> {
    let mut spans = Vec::new();
    compound.spans(ray, &mut spans);
    spans
}

fn ends(spans: &[Span<Face>]) -> Vec<[f64; 2]> {
    spans.iter().map(|s| [s.enter.t, s.exit.t]).collect()
}

fn cuboid(min: [f64; 3], max: [f64; 3]) -> Csg {
    let [min, max] = [min, max].map(|[x, y, z]| Vec3::new(x, y, z));
    Csg::cuboid(Bounds { min, max })
}

/// Calls `check` with three random solids and rays.
fn for_solids(rounds: usize, mut check: impl FnMut([Csg; 3], &[Ray])) {
    let mut random = Random::new(71);
    for i in 0..rounds {
        let aligned = i % 2 == 0;
        let solids = [(); 3].map(|()| random_solid(&mut random, aligned));
        let rays: Vec<_> = (0..100).map(|_| random_ray(&mut random, aligned)).collect();
        check(solids, &rays);
    }
}

#[test]
fn laws_of_sets_hold_exactly() {
    let mut laws = Laws::default();
    laws.try_on(1000, &mut Random::new(74));
    println!("{laws}");
    assert!(laws.hold(), "{laws}");
    assert!(laws.laws.iter().filter(|law| law.spans > 15_000).count() >= 12, "{laws}");
}

/// What is asked for alone is the first of all, in whatever range, to the last bit.
#[test]
fn closest_is_the_first_end_of_the_spans() {
    let mut random = Random::new(77);
    let mut met = [0; 2];
    for_solids(120, |[a, b, c], rays| {
        let plane = Csg::half_space(random.cube(), random.direction());
        let compounds = [
            a.clone().intersection(plane),
            a.clone().difference(b.clone()),
            a.union(b).difference(c),
        ];
        for compound in compounds.map(|csg| csg.build().unwrap()) {
            for ray in rays {
                let ends = spans(&compound, &ray.whole());
                let ends =
                    ends.iter().flat_map(|s| [s.enter.t, s.exit.t]).filter(|t| t.is_finite());
                let span = ends.fold([0.0, 1.0], |[a, b], t| [t.min(a), t.max(b)]);
                let mut at = || span[0] + (span[1] - span[0]) * (1.4 * random.unit() - 0.2);
                let (low, high) = (at(), at());
                for ray in [*ray, ray.with_range(low.min(high), low.max(high))] {
                    let first = spans(&compound, &ray)
                        .into_iter()
                        .flat_map(|s| [s.enter, s.exit])
                        .find(|end| end.wall.is_some());
                    assert_eq!(compound.closest(&ray), first, "{ray:?}");
                    assert_eq!(compound.any(&ray), first.is_some());
                    met[usize::from(first.is_some())] += 1;
                }
            }
        }
    });
    assert!(met.iter().all(|count| *count > 6_000), "{met:?}");
}

/// Faces that coincide do so up to the rounding of where they are placed, and of where rays come from.
#[test]
fn faces_that_coincide_leave_no_splinters_wherever_they_are() {
    let mut random = Random::new(73);
    let tilt = Affine::rotate(Vec3::new(0.3, -0.5, 0.8), 0.7);
    let maps = [
        tilt,
        Affine::translate(Vec3::new(1e3, -3e3, 2e3)).after(&tilt),
        Affine::translate(Vec3::new(-1e6, 1e6, 1e5)),
        tilt.after(&Affine::scale(Vec3::splat(1e-6))),
        tilt.after(&Affine::scale(Vec3::splat(1e6))),
        tilt.after(&Affine::scale(Vec3::new(1.0, 0.2, 3.0))),
    ];
    for _ in 0..400 {
        let [a, b] = [(); 2].map(|()| random_solid(&mut random, true));
        for map in &maps {
            let compounds = [
                // A wall and what fills it to the brim: what is left is nowhere.
                a.clone().union(b.clone()).difference(a.clone()).difference(b.clone()),
                a.clone().difference(a.clone().intersection(b.clone())).intersection(b.clone()),
            ];
            // The same, with one operand placed in two steps: its rounding is another one.
            let again = a
                .clone()
                .placed(&Affine::rotate(Vec3::X, 0.3))
                .placed(&Affine::rotate(Vec3::X, -0.3));
            let nothing =
                [compounds[0].clone(), compounds[1].clone(), again.clone().difference(a.clone())];
            let nothing = nothing.map(|x| x.placed(map).build().unwrap());
            let [whole, cut] =
                [a.clone(), again.intersection(a.clone())].map(|x| x.placed(map).build().unwrap());
            for i in 0..20 {
                // Rays along axes would run within faces, where either is right.
                let own = random_ray(&mut random, false);
                let back = if i % 4 == 3 { own.direction * 1e6 } else { Vec3::ZERO };
                // Parallel to a plane up to rounding, a ray may pass it somewhere beyond.
                let ray = Ray::line(map.point(own.origin - back), map.vector(own.direction))
                    .with_range(-1e7, 1e7);
                for (n, x) in nothing.iter().enumerate() {
                    let found = spans(x, &ray);
                    assert!(found.is_empty(), "{n} {map:?} {ray:?} {found:?} {a:?} {b:?}");
                }
                assert_eq!(
                    spans(&cut, &ray).len(),
                    spans(&whole, &ray).len(),
                    "{map:?} {ray:?} {a:?}"
                );
            }
        }
    }
}

#[test]
fn inside_agrees_with_spans_and_normals_point_out() {
    let (mut all, mut off) = (0, 0);
    for_solids(1000, |[a, b, c], rays| {
        let compound = a.difference(b).union(c).build().unwrap();
        for line in rays.iter().take(30) {
            let ray = line.with_range(-20.0, 20.0);
            let spans = spans(&compound, &ray);
            assert!(spans.iter().all(|s| s.enter.t < s.exit.t), "{ray:?}");
            assert!(spans.is_sorted_by(|a, b| a.exit.t < b.enter.t), "{ray:?}");
            for span in &spans {
                all += 1;
                off += usize::from(!compound.contains(ray.at(0.5 * (span.enter.t + span.exit.t))));
                for (end, sign) in [(span.enter, -1.0), (span.exit, 1.0)] {
                    let Some(face) = end.wall else { continue };
                    let at = compound.interaction(&ray, &face);
                    let speed = ray.direction.length();
                    assert!(
                        sign * at.normal.dot(ray.direction) > -1e-7 * speed,
                        "{ray:?} {face:?}"
                    );
                    let away = (at.point - ray.at(end.t)).length();
                    assert!(away < 1e-6, "{ray:?} {away:e}");
                    assert!((at.normal.length() - 1.0).abs() < 1e-14);
                    // Away from edges the two sides differ.
                    let step = at.normal * 1e-7;
                    all += 1;
                    let [out, inside] = [at.point + step, at.point - step];
                    off += usize::from(compound.contains(out) || !compound.contains(inside));
                }
            }
            for gap in spans.windows(2) {
                all += 1;
                off +=
                    usize::from(compound.contains(ray.at(0.5 * (gap[0].exit.t + gap[1].enter.t))));
            }
        }
    });
    // Rays along axes run within faces, where either is right.
    println!("{off} of {all}");
    assert!(all > 50_000 && off < all / 50, "{off} of {all}");
}

#[test]
fn a_ball_cut_in_half() {
    let cut = Csg::sphere(Vec3::new(1.0, 2.0, 3.0), 2.0)
        .intersection(Csg::half_space(Vec3::new(0.0, 0.0, 3.0), Vec3::Z * 0.5))
        .build()
        .unwrap();
    let mut random = Random::new(72);
    for _ in 0..10_000 {
        let ray = random.line(Vec3::new(1.0, 2.0, 2.5), 3.0);
        let (o, d) = (ray.origin - Vec3::new(1.0, 2.0, 3.0), ray.direction);
        let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - 4.0);
        let disc = b * b - a * c;
        let root = disc.max(0.0).sqrt();
        let plane = -o.z / d.z;
        let [mut enter, mut exit] = [(-b - root) / a, (-b + root) / a];
        if d.z > 0.0 {
            exit = exit.min(plane);
        } else {
            enter = enter.max(plane);
        }
        let found = ends(&spans(&cut, &ray));
        if disc < 1e-9 || (exit - enter).abs() < 1e-9 {
            continue;
        }
        if exit < enter {
            assert!(found.is_empty(), "{ray:?}");
            continue;
        }
        assert_eq!(found.len(), 1, "{ray:?}");
        assert!((found[0][0] - enter).abs() + (found[0][1] - exit).abs() < 1e-9, "{ray:?}");
    }
}

#[test]
fn of_faces_that_coincide_the_first_operand_has_the_data() {
    let down = Ray::line(Vec3::new(0.3, 0.2, 5.0), -Vec3::Z);
    let cylinder = |z0: f64, z1: f64| turned(&format!("M 0 {z0} H 1 V {z1} H 0"));
    let block = cuboid([-2.0, -2.0, 0.0], [2.0, 2.0, 0.7]);
    let leaves = |csg: Csg| -> Vec<(usize, bool)> {
        let compound = csg.build().unwrap();
        let spans = spans(&compound, &down);
        let faces = spans.iter().flat_map(|s| [s.enter.wall.unwrap(), s.exit.wall.unwrap()]);
        faces.map(|f| (f.leaf(), f.flipped)).collect()
    };
    // Both end at 0.7; the cylinder goes on below.
    assert_eq!(leaves(cylinder(-1.0, 0.7).union(block.clone())), [(0, false), (0, false)]);
    assert_eq!(leaves(block.clone().union(cylinder(-1.0, 0.7))), [(0, false), (1, false)]);
    assert_eq!(leaves(cylinder(-1.0, 0.7).intersection(block.clone())), [(0, false), (1, false)]);
    // One stands on the other: no boundary between them.
    assert_eq!(leaves(cylinder(0.7, 2.0).union(block.clone())), [(0, false), (1, false)]);
    // What only touches changes nothing.
    assert_eq!(leaves(cylinder(0.7, 2.0).difference(block.clone())), [(0, false), (0, false)]);
    assert_eq!(leaves(cylinder(0.7, 2.0).intersection(block.clone())), []);
    // A hole from the top face down to 0.2, flush with it.
    let hole = cylinder(0.2, 0.7);
    assert_eq!(leaves(block.clone().difference(hole)), [(1, true), (0, false)]);
    let half = Csg::half_space(Vec3::new(0.0, 0.0, 0.7), Vec3::Z);
    assert_eq!(leaves(cylinder(-1.0, 0.7).intersection(half.clone())), [(0, false), (0, false)]);
    assert_eq!(leaves(cylinder(-1.0, 0.7).difference(half)), []);
}

/// Looks from above at solids cut at the height of each of their own vertices: the cut face must be
/// there wherever there is something just below it, and nowhere else.
#[test]
fn cuts_at_the_height_of_a_vertex_show_the_right_face() {
    const PIXELS: i32 = 48;
    let rings = "M 1 0 L 2 0 L 2.5 1 L 2 2 L 1 2 L 0.5 1 Z";
    let stairs = "M 0 0 H 3 V 0.1 H 2 V 0.2 H 1 V 0.3 H 0";
    let double_cone = "M 0 0 L 1 0.7 L 0 1.4 L 1 2.1 L 0 2.8";
    let texts = STANDARD.iter().map(|(_, text)| *text).chain([rings, stairs, double_cone]);
    let (mut faces, mut unclear, mut all) = (0, 0, 0);
    for text in texts {
        let profile = Profile::from_path_data(text).unwrap().capped();
        let solid = Arc::new(Solid::new(&profile, FillRule::NonZero).unwrap());
        let size = solid.bounds().extent().length();
        let width = solid.bounds().max.x * 1.05;
        let mut heights: Vec<f64> =
            profile.segments().flat_map(|s| [s.start().z, s.end().z]).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        for z in heights.into_iter().step_by(1) {
            let knife = Csg::half_space(Vec3::new(0.0, 0.0, z), Vec3::Z);
            let cut = Csg::turned(Arc::clone(&solid)).intersection(knife).build().unwrap();
            for eye in [Vec3::new(0.0, 0.0, z + 3.0 * size), Vec3::new(size, -0.7 * size, z + size)]
            {
                for i in 0..PIXELS * PIXELS {
                    let at = |n: i32| (f64::from(n) + 0.5) / f64::from(PIXELS) * 2.0 - 1.0;
                    let p = Vec3::new(at(i % PIXELS) * width, at(i / PIXELS) * width, z);
                    let ray = Ray::new(eye, p - eye);
                    all += 1;
                    let found = spans(&cut, &ray);
                    assert!(found.iter().all(|s| s.enter.t > 1.0 - 1e-9), "{text} {z} {p:?}");
                    let on_face = found.first().is_some_and(|s| (s.enter.t - 1.0).abs() < 1e-12);
                    // Just below, where the ray goes in.
                    let below = [1e-9, 1e-7, 1e-5].map(|t| solid.contains(ray.at(1.0 + t)));
                    if below != [below[0]; 3] {
                        unclear += 1;
                        continue;
                    }
                    assert_eq!(on_face, below[0], "{text} {z} {p:?} {found:?}");
                    if on_face {
                        faces += 1;
                        let at = cut.interaction(&ray, &found[0].enter.wall.unwrap());
                        assert!((at.normal - Vec3::Z).length() < 1e-12, "{text} {z} {at:?}");
                        assert!((at.point - p).length() < 1e-12 * size, "{text} {z} {at:?}");
                    }
                }
            }
        }
    }
    println!("{all} pixels, {faces} on cut faces, {unclear} beside an edge");
    assert!(faces > 20_000 && unclear < all / 500, "{faces} {unclear} {all}");
}

#[test]
fn a_rook_with_battlements() {
    let tower = turned("M 0 0 H 1 V 2 H 0.7 V 1.6 H 0");
    let slot = |angle: f64| {
        cuboid([0.0, -0.15, 1.7], [2.0, 0.15, 3.0]).placed(&Affine::rotate(Vec3::Z, angle))
    };
    let slots = (0..6).map(|i| slot(f64::from(i) * core::f64::consts::TAU / 6.0));
    let rook = Csg::Difference([tower].into_iter().chain(slots).collect()).build().unwrap();
    // Through two opposite slots there is nothing; between them, the wall twice.
    let at = |angle: f64| {
        let d = Vec3::new(angle.cos(), angle.sin(), 0.0);
        ends(&spans(&rook, &Ray::line(Vec3::new(0.0, 0.0, 1.8) - d * 3.0, d)))
    };
    assert!(at(0.0).is_empty());
    let between = at(core::f64::consts::PI / 6.0);
    assert_eq!(between.len(), 2);
    assert!((between[0][0] - 2.0).abs() + (between[0][1] - 2.3).abs() < 1e-14, "{between:?}");
}

#[test]
fn expressions_that_make_no_sense_are_refused() {
    let flat = Csg::sphere(Vec3::ZERO, 1.0).placed(&Affine::scale(Vec3::new(1.0, 0.0, 1.0)));
    let ball = || Csg::sphere(Vec3::ZERO, 1.0);
    let message = |csg: Csg| csg.build().map(|_| ()).unwrap_err().to_string();
    assert_eq!(
        message(ball().union(flat)),
        "primitive 1: the placement has no finite inverse; it must not flatten space"
    );
    assert_eq!(Csg::Union(vec![]).build().map(|_| ()), Err(CsgError::NoOperands));
    assert_eq!(
        message(Csg::half_space(Vec3::ZERO, Vec3::ZERO)),
        "primitive 0: the half space has the normal (0, 0, 0); the normal must be finite and not \
         zero, its point finite"
    );
    assert_eq!(
        message(ball().difference(cuboid([0.0; 3], [1.0, 1.0, -1.0]))),
        "primitive 1: the box from (0, 0, 0) to (1, 1, -1) has no volume; each coordinate must be \
         finite and grow from the first corner to the second"
    );
}
