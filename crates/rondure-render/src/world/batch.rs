//! Rays that are alike, asked about together: those of neighbouring pixels from the camera.

use rondure::{Hit, Hits, Ray, RayColumns};

use super::{Contact, World};
use crate::few::Few;

/// Where rays that are asked about together meet the world, with room to work it out.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    /// One for each ray.
    pub(crate) contacts: Vec<Option<Contact>>,
    columns: RayColumns,
    /// Up to where each ray has to be followed, and what it meets there.
    ends: Vec<f64>,
    best: Vec<Option<(u32, Hit)>>,
    hits: Hits,
    flat: Vec<Option<(u32, f64)>>,
}

impl World {
    /// What [`closest`](Self::closest) finds for each of some rays that are alike, apart by rounding, which depends on all of them.
    pub(crate) fn closest_of_many(&self, rays: &[Ray], batch: &mut Batch) {
        batch.begin(rays);
        match &self.few {
            Some(few) => self.closest_of_few(few, rays, batch),
            None if self.closest_in_trees(rays, batch) => {}
            None => {
                batch.contacts.extend(rays.iter().map(|ray| self.closest(ray)));
                return;
            }
        }
        let Batch { contacts, ends, best, .. } = batch;
        let shortened = rays.iter().zip(ends).map(|(ray, end)| Ray { t_max: *end, ..*ray });
        contacts.extend(best.iter().zip(shortened).map(|(best, ray)| self.or_body(*best, ray)));
    }

    /// The nearest of few things.
    fn closest_of_few(&self, few: &Few, rays: &[Ray], batch: &mut Batch) {
        few.flats().closest_of_many(&batch.columns.rays(), &mut batch.flat);
        for i in 0..rays.len() {
            let hit = |(thing, t)| (thing, Hit { t, piece: 0, s: 0.0 });
            batch.consider(i, batch.flat[i].map(hit));
        }
        for &thing in few.simple() {
            self.meet(thing, rays, batch);
        }
        for thing in few.turned() {
            self.meet(thing, rays, batch);
        }
    }

    /// The nearest of many things; false if the rays are not alike enough to go through their trees together.
    fn closest_in_trees(&self, rays: &[Ray], batch: &mut Batch) -> bool {
        let columns = core::mem::take(&mut batch.columns);
        let alike = [&self.blocking, &self.passing].into_iter().all(|tree| {
            tree.walk_together(&columns.rays(), |thing| {
                self.meet_columns(thing, rays, &columns, batch);
                batch.ends.iter().fold(f64::NEG_INFINITY, |latest, end| latest.max(*end))
            })
        });
        batch.columns = columns;
        alike
    }

    /// Takes account of where rays meet a thing.
    fn meet(&self, thing: u32, rays: &[Ray], batch: &mut Batch) {
        let columns = core::mem::take(&mut batch.columns);
        self.meet_columns(thing, rays, &columns, batch);
        batch.columns = columns;
    }

    fn meet_columns(&self, thing: u32, rays: &[Ray], columns: &RayColumns, batch: &mut Batch) {
        if (thing as usize) < self.things.turned.len() {
            let turned = &self.things.turned;
            turned.closest_of_many(thing, &columns.rays().with_ends(&batch.ends), &mut batch.hits);
            for i in 0..rays.len() {
                batch.consider(i, batch.hits.get(i).map(|hit| (thing, hit)));
            }
            return;
        }
        for (i, ray) in rays.iter().enumerate() {
            let hit = self.things.closest(thing, &Ray { t_max: batch.ends[i], ..*ray });
            batch.consider(i, hit.map(|hit| (thing, hit)));
        }
    }
}

impl Batch {
    /// Nothing met yet by these rays.
    fn begin(&mut self, rays: &[Ray]) {
        self.contacts.clear();
        self.columns.clear();
        self.columns.extend_from_slice(rays);
        self.ends.clear();
        self.ends.extend(rays.iter().map(|ray| ray.t_max));
        self.best.clear();
        self.best.resize(rays.len(), None);
    }

    /// Takes account of where a ray meets a thing, if it does.
    #[inline]
    fn consider(&mut self, ray: usize, met: Option<(u32, Hit)>) {
        let Some((thing, hit)) = met else { return };
        self.best[ray] = nearer(self.best[ray], thing, Some(hit));
        self.ends[ray] = hit.t;
    }
}

/// The nearer of two hits; at the same place that on the thing of the smaller number.
#[inline]
fn nearer(best: Option<(u32, Hit)>, thing: u32, hit: Option<Hit>) -> Option<(u32, Hit)> {
    match (best, hit) {
        (Some((other, at)), Some(hit)) if hit.t > at.t || (hit.t == at.t && thing > other) => best,
        (_, Some(hit)) => Some((thing, hit)),
        (_, None) => best,
    }
}
