//! Rays that are alike, asked about together: those of neighbouring pixels from the camera.

use rondure::{Hit, Hits, Ray, RayColumns};

use super::{Contact, World};

/// Where rays that are asked about together meet the world, with room to work it out.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    /// One for each ray.
    pub(crate) contacts: Vec<Option<Contact>>,
    columns: RayColumns,
    hits: Hits,
    flat: Vec<Option<(u32, f64)>>,
    best: Vec<Option<(u32, Hit)>>,
}

impl World {
    /// What [`closest`](Self::closest) finds for each of some rays that are alike, apart by rounding, which depends on all of them.
    pub(crate) fn closest_of_many(&self, rays: &[Ray], batch: &mut Batch) {
        let Batch { contacts, columns, hits, flat, best } = batch;
        contacts.clear();
        let Some(few) = &self.few else {
            contacts.extend(rays.iter().map(|ray| self.closest(ray)));
            return;
        };
        best.clear();
        columns.clear();
        columns.extend_from_slice(rays);
        few.all.flats().closest_of_many(&columns.rays(), flat);
        for (i, flat) in flat.iter().enumerate() {
            best.push(flat.map(|(thing, t)| (thing, Hit { t, piece: 0, s: 0.0 })));
            columns.set_end(i, flat.map_or(rays[i].t_max, |(_, t)| t));
        }
        let asked = (0..rays.len()).map(|i| columns.rays().get(i));
        let met = asked.fold(0, |met, ray| met | few.all.met(&ray));
        for thing in few.all.things(met) {
            let together = self.things.closest_of_many(thing, &columns.rays(), hits);
            for (i, nearest) in best.iter_mut().enumerate() {
                let hit = match together {
                    true => hits.get(i),
                    false => self.things.closest(thing, &columns.rays().get(i)),
                };
                if let Some(hit) = hit {
                    *nearest = nearer(*nearest, thing, hit);
                    columns.set_end(i, hit.t);
                }
            }
        }
        let shortened =
            |(i, ray): (usize, &Ray)| Ray { t_max: columns.rays().ranges()[1][i], ..*ray };
        let met = best.iter().zip(rays.iter().enumerate().map(shortened));
        contacts.extend(met.map(|(nearest, shortened)| self.or_body(*nearest, shortened)));
    }
}

/// The nearer of two hits; at the same place that on the thing of the smaller number.
#[inline]
fn nearer(best: Option<(u32, Hit)>, thing: u32, hit: Hit) -> Option<(u32, Hit)> {
    match best {
        Some((other, at)) if hit.t > at.t || (hit.t == at.t && thing > other) => best,
        _ => Some((thing, hit)),
    }
}
