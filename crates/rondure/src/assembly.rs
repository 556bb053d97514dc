//! A whole scene of placed surfaces, and the questions that can be asked of it.

use fearless_simd::dispatch;

use crate::bvh::{Bvh, TooManyItems};
use crate::{Bounds, Hit, Instances, Interaction, Ray};

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

    /// The closest hit of each of many rays: `hits[i]` for `rays[i]`. What is longer of the two slices
    /// is left alone.
    pub fn closest_many(&self, rays: &[Ray], hits: &mut [Option<Contact>]) {
        dispatch!(self.tree.level(), simd => {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = self.closest_with(simd, ray);
            }
        });
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
