//! The wide engine finds what the exact one finds, with every instruction set: the command `agree` in small.

use rondure::{Hit, Ray, Surface, engine::Instructions};
use rondure_oracle::agree::{
    Amount, Contender, Count, Entrant, Failure, Shape, compare, shapes, wide,
};

#[test]
fn wide_agrees_with_exact() -> Result<(), rondure::ProfileError> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let amount = Amount { random: 20_000, adversarial: 20_000, seed: 1, threads };
    let forced = [Instructions::Portable, Instructions::Avx2, Instructions::Avx512];
    let mut failures = Vec::new();
    for shape in shapes()? {
        let entrants = wide(&shape, &forced);
        assert!(!entrants.is_empty());
        for (entrant, count) in entrants.iter().zip(compare(&shape, &entrants, &amount)) {
            assert_eq!(count.rays, amount.random + amount.adversarial);
            assert!(count.hits > 0, "{}: nothing was hit", shape.name);
            for Failure { kind, words } in count.failures.iter().take(2) {
                failures.push(format!("{} {}, {kind}: {words}", shape.name, entrant.name));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    Ok(())
}

/// A surface whose answers are spoiled: the comparison must see it.
struct Spoiled {
    surface: Surface,
    spoil: fn(&mut Vec<Hit>),
}

impl Contender for Spoiled {
    fn closest(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        let mut all = Vec::new();
        Contender::all(self, rays, &mut all);
        hits.clear();
        hits.extend(all.iter().map(|own| own.first().copied()));
    }
    fn any(&self, rays: &[Ray], found: &mut Vec<bool>) {
        found.clear();
        found.extend(rays.iter().map(|ray| self.surface.any(ray)));
    }
    fn all(&self, rays: &[Ray], hits: &mut Vec<Vec<Hit>>) {
        Contender::all(&self.surface, rays, hits);
        hits.iter_mut().for_each(self.spoil);
    }
}

fn spoiled(shape: &Shape, spoil: fn(&mut Vec<Hit>)) -> Count {
    let options = rondure::EngineOptions { method: rondure::Method::Exact, ..Default::default() };
    let surface = Surface::with_engine(&shape.profile, &options);
    let contender = Box::new(Spoiled { surface, spoil });
    let amount = Amount { random: 2_000, adversarial: 0, seed: 2, threads: 1 };
    compare(shape, &[Entrant { name: "spoiled", contender }], &amount).remove(0)
}

#[test]
fn every_kind_of_disagreement_is_seen() -> Result<(), rondure::ProfileError> {
    let vase = shapes()?.into_iter().find(|shape| shape.name == "vase");
    let vase = vase.as_ref().map(|vase| move |spoil| spoiled(vase, spoil));
    assert!(vase.is_some());
    if let Some(spoiled) = vase {
        assert!(spoiled(|_| {}).is_clean());
        assert!(spoiled(|hits| hits.truncate(hits.len().saturating_sub(1))).lost > 100);
        assert!(spoiled(|hits| hits.truncate(1)).lost > 100);
        assert!(spoiled(|hits| hits.extend_from_within(..hits.len().min(1))).extra > 100);
        assert!(
            spoiled(|hits| hits.iter_mut().for_each(|h| h.piece = (h.piece + 1) % 4)).other > 100
        );
        assert!(spoiled(|hits| hits.iter_mut().for_each(|h| h.t *= 1.0 + 1e-11)).off > 100);
        assert!(spoiled(|hits| hits.reverse()).inconsistent > 100);
    }
    Ok(())
}
