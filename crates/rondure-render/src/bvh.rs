//! The tree of boxes over the bounded shapes.
//!
//! Built once by binned surface area heuristic (Wald 2007, "On fast Construction of SAH-based
//! Bounding Volume Hierarchies"), then flat: a node's children lie side by side. Rays walk it with
//! a small stack, the nearer child first. The slab test errs only towards visiting (Ize 2013,
//! "Robust BVH Ray Traversal").

use rondure::{Bounds, Ray, Vec3, numeric::gamma};

const BINS: usize = 16;
/// The depth up to which the heuristic decides; below it nodes are halved by count, so that with
/// at most 2^32 leaves no path is longer than [`STACK`].
const HEURISTIC_DEPTH: usize = 30;
const STACK: usize = 64;
const SMALL_STACK: usize = 12;
/// The cost of visiting a node, in units of a shape's test: turned shapes are dear.
const NODE_COST: f64 = 0.25;

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// Leaf: the first of its entries in `order`; else: the first of its two children.
    first: u32,
    /// The number of entries of a leaf; 0 in an inner node.
    count: u32,
}

/// A bounding volume hierarchy over numbered items.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    order: Vec<u32>,
    depth: usize,
}

struct Item {
    bounds: Bounds,
    center: Vec3,
    index: u32,
}

impl Bvh {
    pub(crate) fn new(items: impl IntoIterator<Item = (u32, Bounds)>) -> Self {
        let mut items: Vec<_> = items
            .into_iter()
            .map(|(index, bounds)| Item { bounds, center: bounds.center(), index })
            .collect();
        let mut bvh = Self { nodes: Vec::new(), order: Vec::with_capacity(items.len()), depth: 0 };
        if !items.is_empty() {
            bvh.nodes.push(Node { bounds: Bounds::EMPTY, first: 0, count: 0 });
            bvh.fill(0, &mut items, 0);
        }
        bvh
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    fn fill(&mut self, node: usize, items: &mut [Item], depth: usize) {
        self.depth = self.depth.max(depth);
        let bounds = items.iter().fold(Bounds::EMPTY, |all, item| all.union(&item.bounds));
        match split(items, &bounds, depth) {
            None => {
                let first = self.order.len() as u32;
                self.order.extend(items.iter().map(|item| item.index));
                self.nodes[node] = Node { bounds, first, count: items.len() as u32 };
            }
            Some(middle) => {
                let first = self.nodes.len();
                self.nodes[node] = Node { bounds, first: first as u32, count: 0 };
                self.nodes.extend([self.nodes[node]; 2]);
                let (left, right) = items.split_at_mut(middle);
                self.fill(first, left, depth + 1);
                self.fill(first + 1, right, depth + 1);
            }
        }
    }

    /// Visits the items whose boxes the ray meets in its range, roughly from near to far, until
    /// `visit` answers true; it may shorten the ray, whose `t_max` is read again. The ray's range
    /// must not begin before 0.
    #[inline]
    pub(crate) fn walk(&self, ray: &mut Ray, visit: impl FnMut(u32, &mut Ray) -> bool) -> bool {
        // Most trees are low; clearing the large stack would cost more than walking them.
        if self.depth <= SMALL_STACK {
            self.walk_with::<SMALL_STACK>(ray, visit)
        } else {
            self.walk_with::<STACK>(ray, visit)
        }
    }

    #[inline]
    fn walk_with<const N: usize>(
        &self,
        ray: &mut Ray,
        mut visit: impl FnMut(u32, &mut Ray) -> bool,
    ) -> bool {
        let Some(root) = self.nodes.first() else { return false };
        let slabs = Slabs::new(ray);
        let Some(entry) = slabs.enter(&root.bounds, ray) else { return false };
        let mut stack = [(0_u32, 0.0_f64); N];
        let mut top = 0;
        let mut current = (0_u32, entry);
        loop {
            // What came nearer since the node was put aside may hide it.
            if current.1 <= ray.t_max {
                let node = &self.nodes[current.0 as usize];
                if node.count == 0 {
                    let first = node.first;
                    let left = slabs.enter(&self.nodes[first as usize].bounds, ray);
                    let right = slabs.enter(&self.nodes[first as usize + 1].bounds, ray);
                    match (left, right) {
                        (Some(l), Some(r)) => {
                            let (near, far) = if l <= r {
                                ((first, l), (first + 1, r))
                            } else {
                                ((first + 1, r), (first, l))
                            };
                            stack[top] = far;
                            top += 1;
                            current = near;
                            continue;
                        }
                        (Some(l), None) => {
                            current = (first, l);
                            continue;
                        }
                        (None, Some(r)) => {
                            current = (first + 1, r);
                            continue;
                        }
                        (None, None) => {}
                    }
                } else {
                    let range = node.first as usize..(node.first + node.count) as usize;
                    for &index in &self.order[range] {
                        if visit(index, ray) {
                            return true;
                        }
                    }
                }
            }
            if top == 0 {
                return false;
            }
            top -= 1;
            current = stack[top];
        }
    }
}

/// Where to part the items, which are put in order for it; `None` makes a leaf.
fn split(items: &mut [Item], bounds: &Bounds, depth: usize) -> Option<usize> {
    if items.len() <= 1 {
        return None;
    }
    let centers = items.iter().fold(Bounds::EMPTY, |all, item| all.with_point(item.center));
    let extent = centers.extent();
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    let halve = |items: &mut [Item]| {
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |a, b| {
            a.center[axis].total_cmp(&b.center[axis]).then(a.index.cmp(&b.index))
        });
        Some(middle)
    };
    if depth >= HEURISTIC_DEPTH {
        return halve(items);
    }
    let leaf_cost = items.len() as f64;
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        let (low, width) = (centers.min[axis], extent[axis]);
        if !(width > 0.0) {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0_usize); BINS];
        for item in items.iter() {
            let bin = &mut bins[bin_of(item, axis, low, width)];
            *bin = (bin.0.union(&item.bounds), bin.1 + 1);
        }
        // From the right, the cost of all that lies beyond each border; then from the left.
        let mut beyond = [(0.0, 0); BINS];
        let (mut box_right, mut count_right) = (Bounds::EMPTY, 0);
        for i in (1..BINS).rev() {
            box_right = box_right.union(&bins[i].0);
            count_right += bins[i].1;
            beyond[i] = (box_right.area() * count_right as f64, count_right);
        }
        let (mut box_left, mut count_left) = (Bounds::EMPTY, 0);
        for border in 1..BINS {
            box_left = box_left.union(&bins[border - 1].0);
            count_left += bins[border - 1].1;
            if count_left == 0 || beyond[border].1 == 0 {
                continue;
            }
            let sum = box_left.area() * count_left as f64 + beyond[border].0;
            let cost = 2.0 * NODE_COST + sum / bounds.area();
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, border));
            }
        }
    }
    match best {
        Some((cost, axis, border)) if cost < leaf_cost => {
            let (low, width) = (centers.min[axis], extent[axis]);
            Some(partition(items, |item| bin_of(item, axis, low, width) < border))
        }
        // Boxes that all overlap: parting them saves nothing, but long lists cost.
        _ if items.len() > 4 => halve(items),
        _ => None,
    }
}

fn bin_of(item: &Item, axis: usize, low: f64, width: f64) -> usize {
    (((item.center[axis] - low) / width * BINS as f64) as usize).min(BINS - 1)
}

/// Moves the items for which `first` holds to the front and counts them.
fn partition(items: &mut [Item], first: impl Fn(&Item) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        if first(&items[i]) {
            items.swap(i, count);
            count += 1;
        }
    }
    count
}

/// What the slab tests of one ray share.
struct Slabs {
    origin: Vec3,
    reciprocal: Vec3,
    negative: [bool; 3],
}

impl Slabs {
    #[inline]
    fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let reciprocal = Vec3::new(1.0 / d.x, 1.0 / d.y, 1.0 / d.z);
        let negative = [
            reciprocal.x.is_sign_negative(),
            reciprocal.y.is_sign_negative(),
            reciprocal.z.is_sign_negative(),
        ];
        Self { origin: ray.origin, reciprocal, negative }
    }

    /// The parameter at which the ray enters the box, if it meets it in its range.
    #[inline]
    fn enter(&self, bounds: &Bounds, ray: &Ray) -> Option<f64> {
        // A product is NaN where the ray runs in a face of the box, 0 times infinity; the
        // comparisons then keep what they had, which counts the face as part of the box.
        let (mut near, mut far) = (ray.t_min, ray.t_max);
        let mut cut = |low: f64, high: f64, origin: f64, reciprocal: f64, negative: bool| {
            let (first, second) = if negative { (high, low) } else { (low, high) };
            let enter = (first - origin) * reciprocal;
            let leave = (second - origin) * reciprocal;
            // Three roundings in each parameter (Ize 2013, section 3); t >= 0 is all that counts.
            let leave = leave * (1.0 + 2.0 * gamma(3));
            near = if enter > near { enter } else { near };
            far = if leave < far { leave } else { far };
        };
        let (o, r, n) = (self.origin, self.reciprocal, self.negative);
        cut(bounds.min.x, bounds.max.x, o.x, r.x, n[0]);
        cut(bounds.min.y, bounds.max.y, o.y, r.y, n[1]);
        cut(bounds.min.z, bounds.max.z, o.z, r.z, n[2]);
        (near <= far).then_some(near)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::shape::Sphere;

    fn closest(bvh: &Bvh, spheres: &[Sphere], ray: &Ray) -> Option<(u32, f64)> {
        let mut best = None;
        bvh.walk(&mut ray.clone(), |index, ray| {
            if let Some(t) = spheres[index as usize].closest(ray) {
                ray.t_max = t;
                best = Some((index, t));
            }
            false
        });
        best
    }

    fn brute(spheres: &[Sphere], ray: &Ray) -> Option<f64> {
        spheres.iter().filter_map(|s| s.closest(ray)).min_by(f64::total_cmp)
    }

    fn vector(range: core::ops::Range<f64>) -> impl Strategy<Value = Vec3> {
        (range.clone(), range.clone(), range).prop_map(|(x, y, z)| Vec3::new(x, y, z))
    }

    /// Coordinates that make rays run along axes and through the faces of boxes.
    fn grid_vector() -> impl Strategy<Value = Vec3> {
        (-4..=4, -4..=4, -4..=4)
            .prop_map(|(x, y, z)| Vec3::new(f64::from(x), f64::from(y), f64::from(z)))
    }

    proptest! {
        #[test]
        fn agrees_with_brute_force(
            items in prop::collection::vec((vector(-9.0..9.0), 0.01..2.0), 1..80),
            rays in prop::collection::vec((vector(-12.0..12.0), vector(-1.0..1.0)), 30),
            scale in prop::sample::select(vec![1e-6, 1.0, 1e9]),
        ) {
            let spheres: Vec<_> =
                items.iter().map(|&(c, r)| Sphere::new(c * scale, r * scale)).collect();
            let boxes = spheres.iter().enumerate().map(|(i, s)| (i as u32, s.bounds()));
            let bvh = Bvh::new(boxes);
            for (origin, direction) in rays {
                let ray = Ray::new(origin * scale, direction);
                prop_assert_eq!(
                    closest(&bvh, &spheres, &ray).map(|(_, t)| t),
                    brute(&spheres, &ray)
                );
                let any = bvh.walk(&mut ray.clone(), |i, ray| {
                    spheres[i as usize].closest(ray).is_some()
                });
                prop_assert_eq!(any, brute(&spheres, &ray).is_some());
            }
        }

        #[test]
        fn agrees_on_rays_along_faces(
            items in prop::collection::vec((grid_vector(), 1..3), 1..40),
            rays in prop::collection::vec((grid_vector(), grid_vector()), 30),
        ) {
            let spheres: Vec<_> =
                items.iter().map(|&(c, r)| Sphere::new(c, f64::from(r) * 0.5)).collect();
            let bvh = Bvh::new(spheres.iter().enumerate().map(|(i, s)| (i as u32, s.bounds())));
            for (origin, direction) in rays {
                if direction == Vec3::ZERO {
                    continue;
                }
                let ray = Ray::new(origin, direction);
                prop_assert_eq!(
                    closest(&bvh, &spheres, &ray).map(|(_, t)| t),
                    brute(&spheres, &ray)
                );
            }
        }
    }

    #[test]
    fn many_equal_boxes_do_not_overflow_the_stack() {
        let spheres = vec![Sphere::new(Vec3::ZERO, 1.0); 5000];
        let bvh = Bvh::new(spheres.iter().enumerate().map(|(i, s)| (i as u32, s.bounds())));
        let hit = closest(&bvh, &spheres, &Ray::new(Vec3::new(0.0, 0.0, 5.0), -Vec3::Z));
        assert_eq!(hit.map(|(_, t)| t), Some(4.0));
    }

    #[test]
    fn sizes_that_grow_geometrically_do_not_overflow_the_stack() {
        let spheres: Vec<_> = (0..900)
            .map(|i| {
                let size = 2.0_f64.powi(i - 450);
                Sphere::new(Vec3::new(size, 0.0, 0.0), size * 0.1)
            })
            .collect();
        let bvh = Bvh::new(spheres.iter().enumerate().map(|(i, s)| (i as u32, s.bounds())));
        let ray = Ray::new(Vec3::new(-1.0, 0.0, 0.0), Vec3::X);
        assert!(closest(&bvh, &spheres, &ray).is_some());
    }
}
