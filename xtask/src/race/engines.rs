//! The contestants: Rondure's engines, as a user of the crate calls them, and Embree's scenes.

use std::hint::black_box;

use rondure::{Assembly, Contacts, Hits, Surface};

use super::contest::Contestant;
use super::embree::Scene;
use super::rays::{Query, RaySet};

impl Contestant for Surface {
    fn answer(&self, set: &RaySet) -> Option<u64> {
        if set.batch {
            let rays = set.columns.rays();
            return Some(match set.query {
                Query::Closest => {
                    let mut hits = Hits::default();
                    self.closest_of_many(&rays, &mut hits);
                    hits.t.iter().filter(|t| t.is_finite()).count() as u64
                }
                Query::Any => {
                    let mut hits = vec![false; rays.len()];
                    self.any_of_many(&rays, &mut hits);
                    hits.iter().filter(|hit| **hit).count() as u64
                }
            });
        }
        let count = match set.query {
            Query::Closest => {
                set.rays.iter().filter(|ray| black_box(self.closest(ray)).is_some()).count()
            }
            Query::Any => set.rays.iter().filter(|ray| self.any(ray)).count(),
        };
        Some(count as u64)
    }
}

impl Contestant for Assembly {
    fn answer(&self, set: &RaySet) -> Option<u64> {
        if set.batch {
            let rays = set.columns.rays();
            return Some(match set.query {
                Query::Closest => {
                    let mut contacts = Contacts::default();
                    self.closest_of_many(&rays, &mut contacts);
                    contacts.hits.t.iter().filter(|t| t.is_finite()).count() as u64
                }
                Query::Any => {
                    let mut hits = vec![false; rays.len()];
                    self.any_of_many(&rays, &mut hits);
                    hits.iter().filter(|hit| **hit).count() as u64
                }
            });
        }
        let count = match set.query {
            Query::Closest => {
                set.rays.iter().filter(|ray| black_box(self.closest(ray)).is_some()).count()
            }
            Query::Any => set.rays.iter().filter(|ray| self.any(ray)).count(),
        };
        Some(count as u64)
    }
}

impl Contestant for Scene<'_> {
    fn answer(&self, set: &RaySet) -> Option<u64> {
        let far = set.far();
        Some(match (set.query, set.batch) {
            (Query::Closest, false) => self.closest(&set.singles, far),
            (Query::Any, false) => self.any(&set.singles, far),
            (Query::Closest, true) => self.closest_packets(&set.packets, far, set.coherent),
            (Query::Any, true) => self.any_packets(&set.packets, far, set.coherent),
        })
    }
}

/// A scene that answers batches ray by ray: on the finest meshes that can be faster than packets.
pub(crate) struct OneByOne<'a>(pub(crate) &'a Scene<'a>);

impl Contestant for OneByOne<'_> {
    fn answer(&self, set: &RaySet) -> Option<u64> {
        let far = set.far();
        set.batch.then(|| match set.query {
            Query::Closest => self.0.closest(&set.singles, far),
            Query::Any => self.0.any(&set.singles, far),
        })
    }
}
