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
        let mut columns = core::mem::take(&mut batch.columns);
        let is_answered = match &self.few {
            Some(few) => {
                self.closest_of_few(&few.all, &columns, batch);
                true
            }
            None => self.closest_in_trees(&mut columns, batch),
        };
        batch.columns = columns;
        let Batch { contacts, ends, best, .. } = batch;
        if is_answered {
            let shortened = rays.iter().zip(ends).map(|(ray, end)| Ray { t_max: *end, ..*ray });
            contacts.extend(best.iter().zip(shortened).map(|(best, ray)| self.or_body(*best, ray)));
        } else {
            contacts.extend(rays.iter().map(|ray| self.closest(ray)));
        }
    }

    /// The nearest of few things.
    fn closest_of_few(&self, few: &Few, columns: &RayColumns, batch: &mut Batch) {
        let rays = columns.rays();
        few.flats().closest_of_many(&rays, &mut batch.flat);
        for i in 0..rays.len() {
            let hit = |(thing, t)| (thing, Hit { t, piece: 0, s: 0.0 });
            batch.consider(i, batch.flat[i].map(hit));
        }
        let ends = &batch.ends;
        let asked = (0..rays.len()).map(|i| Ray { t_max: ends[i], ..rays.get(i) });
        let met = asked.fold(0, |met, ray| met | few.met(&ray));
        for thing in few.things(met) {
            self.meet(thing, columns, batch);
        }
    }

    /// The nearest of many things; false if the rays are not alike enough to go through their trees together.
    fn closest_in_trees(&self, columns: &mut RayColumns, batch: &mut Batch) -> bool {
        [&self.blocking, &self.passing].into_iter().all(|tree| {
            for (i, end) in batch.ends.iter().enumerate() {
                columns.set_end(i, *end);
            }
            tree.walk_together(&columns.rays(), |thing| {
                self.meet(thing, columns, batch);
                batch.ends.iter().fold(f64::NEG_INFINITY, |latest, end| latest.max(*end))
            })
        })
    }

    /// Takes account of where rays meet a thing.
    fn meet(&self, thing: u32, columns: &RayColumns, batch: &mut Batch) {
        let rays = columns.rays().with_ends(&batch.ends);
        let together = self.things.closest_of_many(thing, &rays, &mut batch.hits);
        for i in 0..batch.ends.len() {
            let hit = if together {
                batch.hits.get(i)
            } else {
                let ray = columns.rays().get(i);
                self.things.closest(thing, &Ray { t_max: batch.ends[i], ..ray })
            };
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
        self.best[ray] = nearer(self.best[ray], thing, hit);
        self.ends[ray] = hit.t;
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rondure::Vec3;

    use super::*;
    use crate::sampler::{Key, Sample};

    /// In lists, in trees, and with bodies, through glass and beside it.
    #[test]
    fn rays_together_meet_what_each_of_them_meets() {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        for name in ["chess", "still-life", "section", "pottery"] {
            let file = scenes.join(name).with_extension("toml");
            let (scene, _) = rondure_scene::read_scene(&file).unwrap();
            let world = World::new(&scene).unwrap();
            let (eye, target) = (scene.camera.eye, scene.camera.look_at);
            let away = (target - eye).length();
            let (mut batch, mut hits) = (Batch::default(), 0);
            for i in 0..600 {
                let sample = Sample::new(7, i, 0, 0);
                let jitter = |key: Key, k: u32| {
                    let (a, b) = sample.pair(key.child(k));
                    let (c, _) = sample.pair(key.child(100 + k));
                    Vec3::new(a, b, c) - Vec3::splat(0.5)
                };
                let aim = target + jitter(Key::ROOT, 0) * (0.8 * away);
                // As the pixels of large pictures are apart, or of tiny ones.
                let apart = [1e-9, 3e-3, 0.02, 0.5][i as usize % 4] * away;
                let rays: Vec<_> = (1..=16)
                    .map(|k| Ray::new(eye, (aim + jitter(Key::LENS, k) * apart - eye).normalized()))
                    .collect();
                world.closest_of_many(&rays, &mut batch);
                assert_eq!(batch.contacts.len(), rays.len());
                for (ray, met) in rays.iter().zip(&batch.contacts) {
                    let alone = world.closest(ray);
                    let place =
                        |contact: &Contact| (contact.thing, (contact.t / away * 1e9).round());
                    let [met, alone] = [met, &alone].map(|contact| contact.as_ref().map(place));
                    assert_eq!(met, alone, "{name}: {ray:?}");
                    hits += u32::from(met.is_some());
                }
            }
            assert!(hits > 3000, "{name}: {hits}");
        }
    }
}
