//! The methods against each other and against all frusta, and the invariants of shells and trees.

use proptest::prelude::*;

use super::shell_tree::{Role, build, direction, monotone_intervals};
use super::strip_tree;
use super::tree::{Link, Tree};
use super::*;
use crate::profile::Point;
use crate::shell::{Cone, Cylinder, Shell, Strip, hybrid};
use crate::{Hit, Profile, Ray, Surface, Vec3};

const PATHS: [&str; 9] = [
    include_str!("../../../../profiles/sphere.path"),
    include_str!("../../../../profiles/cone.path"),
    include_str!("../../../../profiles/cylinder.path"),
    include_str!("../../../../profiles/torus.path"),
    include_str!("../../../../profiles/vase.path"),
    include_str!("../../../../profiles/goblet.path"),
    include_str!("../../../../profiles/pawn.path"),
    include_str!("../../../../profiles/column.path"),
    // Several subpaths, folds in z, self-crossings, nearly horizontal parts.
    "M 1 0 C 3 2 -0.5 2 2 0 Z M 4 1 L 5 1.0000000001 L 5 3 Q 3 2 4 1 M 0 4 A 3 1 20 1 1 0 6",
];

/// The paper's methods, with both criteria.
fn methods() -> Vec<EngineOptions> {
    let of = |method| EngineOptions { method, ..EngineOptions::default() };
    let mut all: Vec<_> =
        [Method::Kj, Method::Cy, Method::Co, Method::Hy, Method::Bs].map(of).to_vec();
    all.push(EngineOptions { criterion: Criterion::Interval, ..of(Method::Hy) });
    all
}

/// Numbers in [-1, 1), the same at every run.
fn random_numbers(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A profile of random Bézier curves, lines and horizontal and vertical stretches.
fn random_profile(seed: u64) -> Profile {
    let mut random = random_numbers(seed);
    let mut r = |scale: f64| scale * (1.0 + random());
    let mut builder = Profile::builder().move_to(r(1.0), r(1.0));
    let mut last = [1.0, 1.0];
    for i in 0..6 {
        let end = [r(1.0), r(2.0)];
        builder = match (seed + i) % 5 {
            0 => builder.line_to(end[0], last[1]),
            1 => builder.line_to(last[0], end[1]),
            2 => builder.quad_to([r(1.0), r(2.0)], end[0], end[1]),
            _ => builder.cubic_to([r(1.0), r(2.0)], [r(1.0), r(2.0)], end[0], end[1]),
        };
        last = match (seed + i) % 5 {
            0 => [end[0], last[1]],
            1 => [last[0], end[1]],
            _ => end,
        };
    }
    builder.build().unwrap()
}

/// A ray near a surface, by turns of a kind that is easy, or hard in one way.
fn ray_near(surface: &Surface, kind: usize, random: &mut impl FnMut() -> f64) -> Ray {
    let (center, extent) = (surface.bounds().center(), surface.bounds().extent());
    let mut point = || Vec3::new(random() * extent.x, random() * extent.y, random() * extent.z);
    let (mut origin, mut direction) = (center + point(), point());
    let [_, end] = surface.piece_ends().nth((kind * 7919) % surface.piece_count()).unwrap();
    match kind % 12 {
        // Nearly perpendicular to the axis, and exactly, at the height of a point of the profile.
        1 => direction.z *= 1e-12,
        2 => {
            direction.z = 0.0;
            origin.z = end.z;
        }
        // Nearly parallel to the axis, and exactly, at the radius of a point.
        3 => direction = Vec3::new(1e-9 * direction.x, direction.y * 1e-7, direction.z),
        4 => {
            direction = Vec3::Z;
            origin = Vec3::new(end.r, 0.0, origin.z);
        }
        // On the axis and through it.
        5 => (origin.x, origin.y, direction.x, direction.y) = (0.0, 0.0, 0.0, 0.0),
        6 => (origin.x, direction.x) = (0.0, 0.0),
        // Tangent to the circle of a point of the profile.
        7 => {
            origin = Vec3::new(end.r, 0.0, end.z);
            direction = Vec3::new(0.0, 1.0, 0.0);
        }
        8 => {
            origin = Vec3::new(end.r, 0.0, end.z) - direction * 0.7;
        }
        // From far away.
        9 => origin = center + direction * -1e5,
        _ => {}
    }
    let range = [[f64::NEG_INFINITY, f64::INFINITY], [0.0, f64::INFINITY], [-0.2, 0.7]][kind % 3];
    Ray::line(origin, direction).with_range(range[0], range[1])
}

/// How often methods disagree with all frusta, on rays through a profile.
fn disagreements(profile: &Profile, samples: u32, subdivide: u32, rays: usize, seed: u64) -> usize {
    let surfaces: Vec<Surface> = methods()
        .into_iter()
        .map(|o| Surface::with_engine(profile, &EngineOptions { samples, subdivide, ..o }))
        .collect();
    let mut random = random_numbers(seed);
    let (mut expected, mut hits) = (Vec::new(), Vec::<Hit>::new());
    let mut wrong = 0;
    for i in 0..rays {
        let ray = ray_near(&surfaces[0], i, &mut random);
        surfaces[0].all_by_brute_force(&ray, &mut expected);
        for (surface, options) in surfaces.iter().zip(methods()) {
            surface.all(&ray, &mut hits);
            let closest = surface.closest(&ray);
            let same = hits == expected
                && closest == expected.first().copied()
                && surface.any(&ray) != expected.is_empty();
            if !same {
                wrong += 1;
                println!("{options:?}\n{ray:?}\n{hits:?}\n{closest:?}\n{expected:?}");
            }
        }
    }
    wrong
}

#[test]
fn every_method_finds_what_all_frusta_have_on_a_million_rays() {
    for (i, path) in PATHS.iter().enumerate() {
        let profile = Profile::from_path_data(path).unwrap();
        for (samples, subdivide) in [(100, 0), (100, 3), (100, 12)] {
            assert_eq!(disagreements(&profile, samples, subdivide, 30_000, 99 + i as u64), 0);
        }
    }
    for seed in 0..200 {
        let wrong = disagreements(&random_profile(seed), 60, (seed % 5) as u32, 1_000, seed);
        assert_eq!(wrong, 0, "profile {seed}");
    }
}

/// The frusta of a profile, lowered as a surface has them, and the radius round them.
fn frusta(profile: &Profile, samples: u32) -> (Vec<Piece>, f64) {
    let options = EngineOptions { method: Method::Cy, samples, ..EngineOptions::default() };
    let surface = Surface::with_engine(profile, &options);
    (surface.pieces.iter().collect(), surface.radius)
}

/// Points that the frusta sweep, as lines parallel to the axis: their only parameter is the height.
fn points(frusta: &[Piece]) -> impl Iterator<Item = Point> + '_ {
    frusta.iter().flat_map(|f| (0..=8).map(|i| f.jet(f64::from(i) / 8.0).point))
}

/// Whether a shell's test and its intersection interval hold a point of the half plane.
fn holds(shell: &impl Shell, p: Point) -> bool {
    let lines = [
        (Vec3::new(p.r, 0.0, p.z), Vec3::Z),
        (Vec3::new(p.r, 0.0, p.z), Vec3::X),
        (Vec3::new(p.r, 0.0, p.z), Vec3::Y),
        (Vec3::new(0.6 * p.r, 0.8 * p.r, p.z), Vec3::new(1.0, 0.4, -0.7)),
    ];
    lines.into_iter().all(|(origin, direction)| {
        // The point is at t = 0, up to rounding.
        let near = 1e-12;
        let ray = Meridian::new(origin, direction);
        shell.meet(&ray, [-near, near]).is_some_and(|stretch| {
            let (lo, hi) = (stretch[0] - near, stretch[1] + near);
            lo <= 0.0 && 0.0 <= hi && shell.intervals(&ray, [lo, hi]).iter().count() > 0
        })
    })
}

fn check_tree<S: Shell>(tree: &Tree<S>, frusta: &[Piece]) -> Result<(), TestCaseError> {
    let mut covered = vec![0; frusta.len()];
    for (i, node) in tree.nodes.iter().enumerate() {
        let part = part_below(tree, i);
        for p in points(&frusta[part.clone()]) {
            prop_assert!(holds(&node.shell, p), "node {i} lost {p:?}");
        }
        if let Link::Leaf(leaf) = node.link {
            prop_assert!(leaf.count > 0);
            prop_assert!(direction(&frusta[part.clone()]).is_some(), "leaf {i} turns");
            covered[part].iter_mut().for_each(|n| *n += 1);
        }
    }
    prop_assert!(covered.iter().all(|n| *n == 1));
    Ok(())
}

/// The frusta below a node. Children follow one another: their parts must join.
fn part_below<S: Shell>(tree: &Tree<S>, node: usize) -> core::ops::Range<usize> {
    match tree.nodes[node].link {
        Link::Leaf(leaf) => leaf.first as usize..(leaf.first + leaf.count) as usize,
        Link::Children { second } => {
            let (a, b) = (part_below(tree, node + 1), part_below(tree, second as usize));
            assert_eq!(a.end, b.start);
            a.start..b.end
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn shells_hold_every_point(seed in 0_u64..1 << 40, k in 0_u32..5) {
        let (frusta, radius) = frusta(&random_profile(seed), 40);
        check_tree(&build(&frusta, k, |p, _| Cylinder::around(p, radius)), &frusta)?;
        check_tree(&build(&frusta, k, |p, _| Cone::or_upright(p, radius)), &frusta)?;
        check_tree(&build(&frusta, k, |p, _| hybrid::least_area(p, radius, 1.0)), &frusta)?;
        check_tree(&build(&frusta, k, |p, _| Strip::around(p, radius)), &frusta)?;
        check_tree(&strip_tree::build(&frusta, radius, k), &frusta)?;
    }

    #[test]
    fn refinement_halves_each_monotone_interval(seed in 0_u64..1 << 40, k in 0_u32..8) {
        let (frusta, radius) = frusta(&random_profile(seed), 60);
        let intervals = monotone_intervals(&frusta);
        for pair in intervals.windows(2) {
            prop_assert_eq!(pair[0].end, pair[1].start);
            // They could not be joined.
            prop_assert!(direction(&frusta[pair[0].start..pair[1].end]).is_none());
        }
        let tree = build(&frusta, k, |p, _| Cylinder::around(p, radius));
        let leaves: Vec<_> = tree.nodes.iter().filter_map(|n| match n.link {
            Link::Leaf(leaf) => Some(leaf.first as usize),
            Link::Children { .. } => None,
        }).collect();
        for interval in intervals {
            let expected = interval.len().min(1 << k);
            let own = leaves.iter().filter(|first| interval.contains(first)).count();
            // Odd parts halve unevenly; the smaller one may be a single frustum early.
            prop_assert!(own <= expected && 2 * own > expected);
            prop_assert!(interval.len() < 1 << k || own == 1 << k);
        }
    }

    #[test]
    fn flags_tell_how_the_frusta_run(seed in 0_u64..1 << 40) {
        let options = EngineOptions { method: Method::Hy, samples: 60, ..EngineOptions::default() };
        let surface = Surface::with_engine(&random_profile(seed), &options);
        let ends: Vec<_> = surface.piece_ends().collect();
        for node in surface.tree() {
            let Some([r, z]) = node.rising else { continue };
            for [a, b] in &ends[node.first..node.first + node.count] {
                let agrees = |flag: Option<bool>, a: f64, b: f64| match flag {
                    Some(true) => b >= a,
                    Some(false) => b <= a,
                    None => a == b,
                };
                prop_assert!(agrees(r, a.r, b.r) && agrees(z, a.z, b.z));
            }
            // With both flags the ends of the part give its extremes (paper, section 3.3).
            let ([first, _], [_, last]) = (ends[node.first], ends[node.first + node.count - 1]);
            for [a, b] in &ends[node.first..node.first + node.count] {
                for p in [a, b] {
                    prop_assert!(first.r.min(last.r) <= p.r && p.r <= first.r.max(last.r));
                    prop_assert!(first.z.min(last.z) <= p.z && p.z <= first.z.max(last.z));
                }
            }
        }
    }

    #[test]
    fn strip_trees_split_where_the_curve_is_farthest(seed in 0_u64..1 << 40) {
        let (frusta, radius) = frusta(&random_profile(seed), 60);
        let tree = strip_tree::build(&frusta, radius, 20);
        for i in 0..tree.nodes.len() {
            let part = part_below(&tree, i);
            let Link::Children { second } = tree.nodes[i].link else {
                prop_assert_eq!(part.len(), 1);
                continue;
            };
            let middle = part_below(&tree, second as usize).start;
            let (cos, sin) = crate::shell::rectangle::chord(&frusta[part.clone()], radius);
            let offset = |p: Point| {
                let [z, w] = crate::shell::rectangle::image(p, radius);
                w * cos - z * sin
            };
            let base = offset(frusta[part.start].start());
            let away = |i: usize| (offset(frusta[i].start()) - base).abs();
            let largest = (part.start + 1..part.end).map(away).fold(0.0, f64::max);
            // Equal but for rounding.
            prop_assert!(away(middle) >= largest - 1e-14 * radius || largest < 1e-14 * radius);
            // No rectangle is wider than the curve demands, but for the sagging of the frusta.
            let sag = part.clone().map(|i| {
                let d = frusta[i].end() - frusta[i].start();
                0.25 * d.r * d.r / radius
            }).fold(0.0, f64::max);
            let last = (offset(frusta[part.end - 1].end()) - base).abs();
            prop_assert!(
                tree.nodes[i].shell.width() <= 2.0 * (largest.max(last) + sag) + 1e-12 * radius
            );
        }
    }
}

#[test]
fn hybrid_leaves_are_cones() {
    let profile = Profile::from_path_data(PATHS[5]).unwrap();
    for criterion in [Criterion::Area { cone_weight: 1.0 }, Criterion::Interval] {
        let method = Method::Hy;
        let options = EngineOptions { method, criterion, ..EngineOptions::default() };
        let nodes = Surface::with_engine(&profile, &options).tree();
        let is_cone = |n: &&TreeNode| matches!(n.region, Region::Cone { .. });
        // But for those along or across the axis, whose cones are cylinders.
        let upright = |n: &TreeNode| n.rising.is_some_and(|flags| flags.contains(&None));
        assert!(nodes.iter().filter(|n| n.leaf).all(|n| is_cone(&n) || upright(n)));
        let inner = nodes.iter().filter(|n| !n.leaf);
        let cones = inner.clone().filter(is_cone).count();
        assert!(0 < cones && cones < inner.count());
    }
    let (frusta, radius) = frusta(&profile, 100);
    build(&frusta, 2, |part, role| {
        let hybrid = hybrid::least_area(part, radius, 1.0).area();
        let both = [Cone::upright(part, radius).area(), Cone::or_upright(part, radius).area()];
        assert!(role == Role::Leaf || hybrid <= both[0].min(both[1]));
        Cylinder::around(part, radius)
    });
}

#[test]
fn intersection_intervals_are_none_one_or_two() {
    let profile = Profile::from_path_data("M 2 -1 Q 2.5 0 2 1").unwrap();
    for method in [Method::Cy, Method::Co] {
        let options = EngineOptions { method, subdivide: 0, ..EngineOptions::default() };
        let surface = Surface::with_engine(&profile, &options);
        let intervals = |x: f64, up: f64| {
            let ray = Ray::line(Vec3::new(x, 0.0, 0.0), Vec3::new(0.0, 1.0, up));
            surface.intersection_intervals(&ray, 0)
        };
        assert_eq!(intervals(3.0, 0.1).len(), 0, "{method:?}: past the outer wall");
        assert_eq!(intervals(2.1, 0.1).len(), 1, "{method:?}: between the walls");
        assert_eq!(intervals(0.5, 0.1).len(), 2, "{method:?}: through the inner wall");
        assert_eq!(intervals(0.5, 3.0).len(), 0, "{method:?}: through the bottom and the top");
    }
}

/// The slope of the error against the number of samples, on a doubly logarithmic scale.
#[test]
fn frusta_converge_to_the_exact_surface_at_second_order() {
    // The goblet has details a fiftieth of its size, which few samples do not resolve.
    for (path, samples) in [(PATHS[3], 100), (PATHS[4], 100), (PATHS[5], 1600)] {
        let profile = Profile::from_path_data(path).unwrap();
        let exact = Surface::new(&profile);
        let errors = [1, 2, 4, 8].map(|finer| {
            let samples = samples * finer;
            let options = EngineOptions { method: Method::Hy, samples, ..EngineOptions::default() };
            let surface = Surface::with_engine(&profile, &options);
            let mut random = random_numbers(5);
            let (mut t, mut normal, mut n) = (0.0, 0.0, 0);
            for _ in 0..20_000 {
                let ray = ray_near(&exact, 0, &mut random);
                let (Some(a), Some(b)) = (exact.closest(&ray), surface.closest(&ray)) else {
                    continue;
                };
                let own = (exact.interaction(&ray, &a), surface.interaction(&ray, &b));
                // Rays that graze the surface meet one and miss the other; they are few.
                if own.0.normal.dot(ray.direction.normalized()).abs() > 0.2
                    && (a.t - b.t).abs() < 0.01
                {
                    t += (a.t - b.t).abs();
                    normal += (own.0.normal - own.1.normal).length();
                    n += 1;
                }
            }
            [t / f64::from(n), normal / f64::from(n)]
        });
        for pair in errors.windows(2) {
            let order = [0, 1].map(|i| (pair[0][i] / pair[1][i]).log2());
            println!("{errors:?} {order:?}");
            assert!((1.8..2.2).contains(&order[0]), "t: {order:?}, {errors:?}");
            assert!((1.7..2.3).contains(&order[1]), "normal: {order:?}, {errors:?}");
        }
    }
}

#[test]
fn counting_changes_nothing_but_counts() {
    let profile = Profile::from_path_data(PATHS[6]).unwrap();
    let options = EngineOptions { method: Method::Hy, ..EngineOptions::default() };
    let plain = Surface::with_engine(&profile, &options);
    let counted = Surface::with_engine(&profile, &EngineOptions { counted: true, ..options });
    assert_eq!(plain.statistics(), None);
    let mut random = random_numbers(3);
    for i in 0..2000 {
        let ray = ray_near(&plain, i, &mut random);
        assert_eq!(plain.closest(&ray), counted.closest(&ray));
    }
    let work = counted.statistics().unwrap();
    assert!(0 < work.rays && work.rays <= 2000);
    assert_eq!(work.nodes_there, work.rays * counted.node_count() as u64);
    assert!(work.nodes_visited <= work.positive_tests && work.positive_tests < work.shell_tests);
    assert!(work.leaf_solves > 0);
}
