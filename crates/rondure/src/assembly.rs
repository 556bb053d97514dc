//! A whole scene of placed surfaces, and the questions that can be asked of it.

use fearless_simd::dispatch;

use crate::bvh::{Bvh, TooManyItems};
use crate::{Bounds, Hit, Hits, Instances, Interaction, Ray, Rays};

/// Surfaces in many places behind a tree of boxes: what a ray costs grows with the logarithm of their
/// number.
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use std::sync::Arc;
/// use rondure::{Affine, Assembly, Instances, Profile, Ray, Surface, Vec3};
///
/// let ball = Surface::new(&Profile::from_path_data("M 0 -1 A 1 1 0 0 1 0 1")?);
/// let mut instances = Instances::new();
/// let ball = instances.add_shape(Arc::new(ball));
/// for i in 0..100 {
///     instances.place(ball, Affine::translate(Vec3::X * (3.0 * f64::from(i))))?;
/// }
/// let row = Assembly::new(instances)?;
/// let met = row.closest(&Ray::new(Vec3::new(9.0, 0.0, -5.0), Vec3::Z));
/// assert_eq!(met.map(|m| (m.instance, m.hit.t)), Some((3, 4.0)));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Assembly {
    instances: Instances,
    tree: Bvh,
}

/// Where a ray meets an assembly: the cheap answer, from which [`Assembly::interaction`] makes the
/// full one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Which instance was hit.
    pub instance: u32,
    /// Where.
    pub hit: Hit,
}

/// How many rays go together.
const PACKET: usize = 16;

/// Where many rays meet an assembly.
#[derive(Clone, Debug, Default)]
pub struct Contacts {
    /// Which instances were hit; of no meaning for rays that hit nothing.
    pub instance: Vec<u32>,
    /// Where.
    pub hits: Hits,
}

impl Contacts {
    /// Where one ray meets it, if it does.
    ///
    /// # Panics
    ///
    /// If there are no more than `index`.
    pub fn get(&self, index: usize) -> Option<Contact> {
        let hit = self.hits.get(index)?;
        Some(Contact { instance: self.instance[index], hit })
    }
}

/// The greatest of the ends of rays.
fn latest(ends: &[f64]) -> f64 {
    ends.iter().fold(f64::NEG_INFINITY, |latest, end| if *end > latest { *end } else { latest })
}

impl Contact {
    /// By which one hit comes before another, and which of several at the same t is the closest one.
    #[inline]
    fn order(&self, other: &Self) -> core::cmp::Ordering {
        let (a, b) = (&self.hit, &other.hit);
        a.t.total_cmp(&b.t).then(self.instance.cmp(&other.instance)).then(a.piece.cmp(&b.piece))
    }
}

impl Assembly {
    /// Builds the tree: on all threads of rayon's pool with the feature `parallel`, on this one
    /// without. It is the same tree either way.
    ///
    /// # Errors
    /// Never for instances that were placed one by one: there are no more than a tree can have.
    pub fn new(instances: Instances) -> Result<Self, TooManyItems> {
        let tree = Bvh::new(instances.len(), |i| instances.bounds(i))?;
        Ok(Self { instances, tree })
    }

    /// What was placed.
    pub fn instances(&self) -> &Instances {
        &self.instances
    }

    /// The box round everything.
    pub fn bounds(&self) -> Bounds {
        self.tree.bounds()
    }

    /// The bytes that instances and tree take, without the surfaces.
    pub fn bytes(&self) -> usize {
        self.instances.bytes() + self.tree.bytes()
    }

    /// The hit with the smallest t in the ray's range, if there is one; of several with the same t
    /// the one on the instance with the smallest number.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Contact> {
        dispatch!(self.tree.level(), simd => self.closest_with(simd, ray))
    }

    /// The hits that [`closest`](Self::closest) finds for each of many rays, apart by rounding. Those of sixteen that follow each other go
    /// together if they are alike, as from a camera through a square of pixels.
    pub fn closest_of_many(&self, rays: &Rays<'_>, contacts: &mut Contacts) {
        let Contacts { instance, hits } = contacts;
        hits.clear(rays.len());
        instance.resize(rays.len(), 0);
        let mut own = Hits::default();
        for start in (0..rays.len()).step_by(PACKET) {
            let some = rays.slice(start..rays.len().min(start + PACKET));
            let mut ends = [0.0; PACKET];
            let ends = &mut ends[..some.len()];
            ends.copy_from_slice(some.ranges()[1]);
            let alike = self.tree.walk_together(&some, |item| {
                self.instances.closest_of_many(item, &some.with_ends(ends), &mut own);
                for (i, end) in ends.iter_mut().enumerate() {
                    let Some(hit) = own.get(i) else { continue };
                    let contact = Contact { instance: item, hit };
                    let best = hits.get(start + i);
                    let best = best.map(|hit| Contact { instance: instance[start + i], hit });
                    if best.is_none_or(|best| contact.order(&best).is_lt()) {
                        hits.set(start + i, Some(hit));
                        instance[start + i] = item;
                        *end = hit.t;
                    }
                }
                latest(ends)
            });
            if alike {
                continue;
            }
            dispatch!(self.tree.level(), simd => for i in 0..some.len() {
                if let Some(contact) = self.closest_with(simd, &some.get(i)) {
                    hits.set(start + i, Some(contact.hit));
                    instance[start + i] = contact.instance;
                }
            });
        }
    }

    /// Whether each of many rays has any hit: `hits[i]` for the i-th. What is longer of the two is left alone.
    pub fn any_of_many(&self, rays: &Rays<'_>, hits: &mut [bool]) {
        let count = rays.len().min(hits.len());
        for start in (0..count).step_by(PACKET) {
            let some = rays.slice(start..count.min(start + PACKET));
            let hits = &mut hits[start..start + some.len()];
            hits.fill(false);
            let (mut ends, mut own) = ([0.0; PACKET], [false; PACKET]);
            let (ends, own) = (&mut ends[..some.len()], &mut own[..some.len()]);
            ends.copy_from_slice(some.ranges()[1]);
            let alike = self.tree.walk_together(&some, |item| {
                self.instances.any_of_many(item, &some.with_ends(ends), own);
                for ((end, hit), own) in ends.iter_mut().zip(&mut *hits).zip(&*own) {
                    if *own {
                        // It needs no other.
                        (*hit, *end) = (true, f64::NEG_INFINITY);
                    }
                }
                latest(ends)
            });
            if !alike {
                for (i, hit) in hits.iter_mut().enumerate() {
                    *hit = self.any(&some.get(i));
                }
            }
        }
    }

    #[inline(always)]
    fn closest_with<S: fearless_simd::Simd>(&self, simd: S, ray: &Ray) -> Option<Contact> {
        let mut best: Option<Contact> = None;
        let mut shortened = *ray;
        self.tree.walk_with(
            simd,
            ray,
            #[inline(always)]
            |instance| {
                if let Some(hit) = self.instances.closest(instance, &shortened) {
                    let contact = Contact { instance, hit };
                    if best.is_none_or(|best| contact.order(&best).is_lt()) {
                        best = Some(contact);
                        shortened.t_max = hit.t;
                    }
                }
                shortened.t_max
            },
        );
        best
    }

    /// Whether there is any hit in the ray's range.
    #[inline]
    pub fn any(&self, ray: &Ray) -> bool {
        let mut found = false;
        self.tree.walk(ray, |instance| {
            found = self.instances.any(instance, ray);
            if found { f64::NEG_INFINITY } else { ray.t_max }
        });
        found
    }

    /// All hits in the ray's range, in order of t, at the same t of the instances' numbers. `hits` is
    /// cleared first.
    pub fn all(&self, ray: &Ray, hits: &mut Vec<Contact>) {
        hits.clear();
        let mut own = Vec::new();
        self.tree.walk(ray, |instance| {
            self.instances.all(instance, ray, &mut own);
            hits.extend(own.iter().map(|&hit| Contact { instance, hit }));
            ray.t_max
        });
        hits.sort_by(Contact::order);
    }

    /// The full answer for a hit that this assembly reported for this ray.
    pub fn interaction(&self, ray: &Ray, contact: &Contact) -> Interaction {
        self.instances.interaction(contact.instance, ray, &contact.hit)
    }
}
