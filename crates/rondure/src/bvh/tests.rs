use core::ops::Range;

use proptest::prelude::*;

use super::*;
use crate::{RayColumns, Vec3};

fn tree(boxes: &[Bounds]) -> Bvh {
    Bvh::new(boxes.len(), |i| boxes[i as usize]).unwrap()
}

fn met(tree: &Bvh, ray: &Ray) -> Vec<u32> {
    let mut items = Vec::new();
    tree.walk(ray, |item| {
        items.push(item);
        ray.t_max
    });
    items.sort_unstable();
    items
}

fn around(center: Vec3, half: Vec3) -> Bounds {
    Bounds { min: center - half, max: center + half }
}

fn vector(range: Range<f64>) -> impl Strategy<Value = Vec3> {
    (range.clone(), range.clone(), range).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

/// Coordinates that make rays run along axes and through the faces, edges and corners of boxes, all
/// without rounding.
fn grid_vector() -> impl Strategy<Value = Vec3> {
    (-4..=4, -4..=4, -4..=4)
        .prop_map(|(x, y, z)| Vec3::new(f64::from(x), f64::from(y), f64::from(z)))
}

/// A place in a box, often on its faces, edges and corners.
fn place_in_box() -> impl Strategy<Value = Vec3> {
    let along = || prop_oneof![Just(-1.0), Just(1.0), -1.0..1.0];
    (along(), along(), along()).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

proptest! {
    /// A ray through a point of a box meets the box, from however far it comes, wherever the boxes
    /// are and however large.
    #[test]
    fn no_box_is_lost(
        items in prop::collection::vec((vector(-9.0..9.0), vector(0.0..2.0), place_in_box()), 1..200),
        directions in prop::collection::vec(vector(-1.0..1.0), 20),
        flat in prop::sample::select(vec![1.0, 1e-6, 1e-9, 1e-300, 0.0]),
        scale in prop::sample::select(vec![1e-90, 1e-6, 1.0, 1e9, 1e90]),
        away in prop::sample::select(vec![0.0, 1.0, 1e3, 1e6]),
        distance in prop::sample::select(vec![0.0, 1.0, 1e3, 1e6, 1e9]),
        place in vector(-1.0..1.0),
    ) {
        let place = place * away;
        // By so much may rounding move a ray off the point.
        let room = 1e-15 * (10.0 + distance + away);
        let boxes: Vec<_> = items
            .iter()
            .map(|&(center, half, _)| around((center + place) * scale, (half + Vec3::splat(room)) * scale))
            .collect();
        let tree = tree(&boxes);
        for (i, direction) in directions.into_iter().enumerate() {
            let item = i * 7 % items.len();
            let (center, half, to) = items[item];
            let point = center + place + Vec3::new(half.x * to.x, half.y * to.y, half.z * to.z);
            let direction = match i % 3 {
                0 => Vec3 { x: direction.x * flat, ..direction },
                1 => Vec3::new(direction.x * flat, direction.y, -direction.y * flat),
                _ => direction,
            };
            if direction.max_abs() < 1e-3 {
                continue;
            }
            let ray = Ray::new((point - direction * distance) * scale, direction * scale);
            prop_assert!(met(&tree, &ray).contains(&(item as u32)), "{item} {ray:?}");
            let near = ray.with_range(distance - 1e-3, distance + 1e-3);
            prop_assert!(met(&tree, &near).contains(&(item as u32)), "{item} {near:?}");
        }
    }

    /// A box through a point of which one of many rays runs that are alike is visited for all of them.
    #[test]
    fn no_box_is_lost_to_rays_together(
        items in prop::collection::vec((vector(-9.0..9.0), vector(0.0..2.0), place_in_box()), 1..200),
        directions in prop::collection::vec(vector(-1.0..1.0), 10),
        jitters in prop::collection::vec((vector(-1.0..1.0), vector(-1.0..1.0)), 15),
        spread in prop::sample::select(vec![0.0, 1e-9, 1e-4, 3e-3, 1e-2]),
        scale in prop::sample::select(vec![1e-90, 1.0, 1e9]),
        distance in prop::sample::select(vec![0.0, 1.0, 30.0, 1e3]),
    ) {
        let room = 1e-15 * (10.0 + distance);
        let boxes: Vec<_> = items
            .iter()
            .map(|&(center, half, _)| around(center * scale, (half + Vec3::splat(room)) * scale))
            .collect();
        let tree = tree(&boxes);
        for (i, direction) in directions.into_iter().enumerate() {
            let item = i * 7 % items.len();
            let (center, half, to) = items[item];
            let point = center + Vec3::new(half.x * to.x, half.y * to.y, half.z * to.z);
            if direction.max_abs() < 1e-3 {
                continue;
            }
            let range = [distance - 1e-3, distance + 1e-3];
            let through = Ray::new((point - direction * distance) * scale, direction * scale)
                .with_range(range[0], range[1]);
            let mut rays: Vec<_> = jitters
                .iter()
                .map(|&(o, d)| Ray {
                    origin: through.origin + o * (spread * scale),
                    direction: through.direction + d * (spread * scale / (10.0 + distance)),
                    ..through
                })
                .collect();
            rays.insert(i * 5 % 16, through);
            let mut items = Vec::new();
            let columns = RayColumns::from_iter(&rays);
            let alike = tree.walk_together(&columns.rays(), |item| {
                items.push(item);
                range[1]
            });
            prop_assert!(!alike || items.contains(&(item as u32)), "{item} {through:?}");
            let widths = boxes.iter().map(|b| b.extent().max_abs()).sum::<f64>();
            let close = spread * scale * 100.0 < widths / boxes.len() as f64;
            prop_assert!(alike || !close || direction.max_abs() < 0.1 || distance > 100.0);
        }
    }

    /// Boxes are closed: a ray in a face or through a corner meets them.
    #[test]
    fn faces_and_corners_belong_to_boxes(
        items in prop::collection::vec((grid_vector(), 0..3), 1..60),
        rays in prop::collection::vec((grid_vector(), grid_vector()), 30),
        zero in prop::sample::select(vec![0.0, -0.0]),
    ) {
        let boxes: Vec<_> = items
            .iter()
            .map(|&(center, size)| around(center, Vec3::splat(f64::from(size))))
            .collect();
        let tree = tree(&boxes);
        for (origin, direction) in rays {
            if direction == Vec3::ZERO {
                continue;
            }
            let signed = |x: f64| if x == 0.0 { zero } else { x };
            let direction = Vec3::new(signed(direction.x), signed(direction.y), signed(direction.z));
            let ray = Ray::new(origin, direction);
            let found = met(&tree, &ray);
            // In steps of 1/840 every crossing of a face at an integer is a step, without rounding
            // in the products of integers.
            let meets = |b: &Bounds| {
                (0..=10 * 840).any(|step| {
                    let at = |o: f64, d: f64| o * 840.0 + d * f64::from(step);
                    (0..3).all(|i| {
                        let x = at(origin[i], direction[i]);
                        b.min[i] * 840.0 <= x && x <= b.max[i] * 840.0
                    })
                })
            };
            for (i, b) in boxes.iter().enumerate() {
                if meets(b) {
                    prop_assert!(found.contains(&(i as u32)), "{b:?} {ray:?}");
                }
            }
        }
    }
}

#[test]
fn every_item_is_visited_once() {
    for count in [0, 1, 2, 7, 8, 9, 63, 64, 65, 1000, 40_000] {
        let boxes: Vec<_> = (0..count)
            .map(|i| around(Vec3::splat(f64::from(i * 37 % 1009)), Vec3::splat(1e4)))
            .collect();
        let all: Vec<_> = (0..count as u32).collect();
        assert_eq!(met(&tree(&boxes), &Ray::new(Vec3::ZERO, Vec3::X)), all);
    }
}

#[test]
fn near_items_come_first_and_far_ones_not_at_all() {
    let boxes: Vec<_> =
        (0..1000).map(|i| around(Vec3::X * (3.0 * f64::from(i)), Vec3::splat(1.0))).collect();
    let tree = tree(&boxes);
    let ray = Ray::new(Vec3::new(-5.0, 0.1, 0.2), Vec3::X);
    let mut visited = Vec::new();
    tree.walk(&ray, |item| {
        visited.push(item);
        5.0 + 3.0 * f64::from(item)
    });
    assert_eq!(visited, [0]);
    visited.clear();
    tree.walk(&ray, |item| {
        visited.push(item);
        if visited.len() == 5 { f64::NEG_INFINITY } else { f64::INFINITY }
    });
    assert_eq!(visited, [0, 1, 2, 3, 4]);
}

#[test]
fn boxes_without_end_are_met_and_empty_ones_are_not() {
    let everything =
        Bounds { min: Vec3::splat(f64::NEG_INFINITY), max: Vec3::splat(f64::INFINITY) };
    let half_space = Bounds { min: Vec3::new(-1e301, 0.0, 0.0), max: Vec3::splat(1.0) };
    let unknown = Bounds { min: Vec3::splat(f64::NAN), max: Vec3::splat(1.0) };
    let ball = around(Vec3::X * 10.0, Vec3::splat(1.0));
    let boxes = [everything, Bounds::EMPTY, half_space, unknown, ball];
    let tree = tree(&boxes);
    assert_eq!(met(&tree, &Ray::new(Vec3::ZERO, Vec3::X)), [0, 2, 3, 4]);
    assert_eq!(met(&tree, &Ray::new(Vec3::ZERO, Vec3::Y)), [0, 2, 3]);
    assert_eq!(tree.bounds(), ball);
    for stop_after in 1..=4 {
        let mut visited = 0;
        tree.walk(&Ray::new(Vec3::ZERO, Vec3::X), |_| {
            visited += 1;
            if visited == stop_after { f64::NEG_INFINITY } else { f64::INFINITY }
        });
        assert_eq!(visited, stop_after);
    }
    assert!(met(&self::tree(&boxes[1..2]), &Ray::new(Vec3::ZERO, Vec3::X)).is_empty());
    assert!(self::tree(&boxes[1..2]).is_empty() && !self::tree(&boxes[..1]).is_empty());
}

#[test]
fn giants_do_not_blur_the_crowd() {
    let mut boxes: Vec<_> = (0..1000)
        .map(|i| around(Vec3::new(f64::from(i % 32), f64::from(i / 32), 0.0), Vec3::splat(0.1)))
        .collect();
    let planet = around(Vec3::Z * -1e9, Vec3::splat(1e9));
    let star = around(Vec3::X * 1e14, Vec3::splat(1.0));
    boxes.extend([planet, star]);
    let mixed = tree(&boxes);
    let ray = Ray::new(Vec3::new(16.0, 16.0, 5.0), -Vec3::Z);
    assert_eq!(met(&mixed, &ray), [16 * 32 + 16, 1000, 1001]);
    assert_eq!(mixed.bounds(), planet.union(&star).union(&around(Vec3::ZERO, Vec3::splat(0.1))));
    // Too many to stand aside: still nothing is lost.
    boxes.extend((0..20).map(|i| around(Vec3::Y * (1e12 * f64::from(i)), Vec3::splat(1e11))));
    assert!(met(&tree(&boxes), &ray).contains(&(16 * 32 + 16)));
    let along = met(&tree(&boxes), &Ray::new(Vec3::Z, Vec3::Y));
    assert!((1002..1022).all(|i| along.contains(&i)));
}

#[test]
fn what_is_no_ray_meets_nothing() {
    let tree = tree(&[around(Vec3::ZERO, Vec3::splat(1.0))]);
    for ray in [
        Ray::new(Vec3::ZERO, Vec3::ZERO),
        Ray::new(Vec3::splat(f64::NAN), Vec3::X),
        Ray::new(Vec3::ZERO, Vec3::X * f64::INFINITY),
        Ray::new(Vec3::ZERO, Vec3::X).with_range(2.0, 1.0),
        Ray::new(Vec3::ZERO, Vec3::X).with_range(2.0, f64::INFINITY),
    ] {
        assert_eq!(met(&tree, &ray), [], "{ray:?}");
    }
    assert_eq!(met(&tree, &Ray::line(Vec3::X * 5.0, Vec3::X)), [0]);
}

#[test]
fn many_equal_boxes_do_not_overflow_the_stack() {
    let boxes = vec![around(Vec3::ZERO, Vec3::splat(1.0)); 50_000];
    assert_eq!(met(&tree(&boxes), &Ray::new(Vec3::ZERO, Vec3::X)).len(), 50_000);
}

#[test]
fn sizes_that_grow_geometrically_do_not_overflow_the_stack() {
    let boxes: Vec<_> = (0..900)
        .map(|i| {
            let size = 2.0_f64.powi(i - 450);
            around(Vec3::X * size, Vec3::splat(0.1 * size))
        })
        .collect();
    let ray = Ray::new(-Vec3::X, Vec3::X);
    assert_eq!(met(&tree(&boxes), &ray).len(), 900);
}

/// The tree does not depend on the number of threads.
#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_builds_the_same_tree() {
    let boxes: Vec<_> = (0..100_000_u32)
        .map(|i| {
            let number = |k: u32| f64::from((i ^ 0x5555).wrapping_mul(k) >> 8) / f64::from(1 << 24);
            let center = Vec3::new(
                number(2_654_435_761),
                number(2_246_822_519) * number(7_919),
                number(3_266_489_917),
            );
            around(center, Vec3::splat(0.01 * number(668_265_263)))
        })
        .collect();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tree(&boxes))
    };
    let one = on(1);
    assert!(one.nodes.len() > 10_000);
    for threads in [2, 3, 8] {
        assert!(one.nodes == on(threads).nodes);
    }
}
