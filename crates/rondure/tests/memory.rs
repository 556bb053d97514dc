//! What a surface keeps: all that is allocated and not freed when nothing else is left, the profile in it included.
//!
//! `cargo test --release -p rondure --test memory -- --nocapture` tells the bytes.

#![allow(clippy::unwrap_used, missing_docs, reason = "a test")]

use std::alloc::System;

use rondure::{Profile, Ray, Surface, Vec3};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// The most bytes of a surface.
const MOST: usize = 64_000;

/// One test, for the allocator counts what all threads do.
#[test]
fn surfaces_are_small() {
    for (name, text, pieces) in [
        ("vase", include_str!("../../../profiles/vase.path"), 6),
        ("goblet", include_str!("../../../profiles/goblet.path"), 16),
        ("pawn", include_str!("../../../profiles/pawn.path"), 34),
        ("column", include_str!("../../../profiles/column.path"), 188),
    ] {
        let region = Region::new(ALLOCATOR);
        let kept = || {
            let change = region.change();
            change.bytes_allocated - change.bytes_deallocated + size_of::<Surface>()
        };
        let profile = Profile::from_path_data(text).unwrap();
        let surface = Surface::new(&profile);
        drop(profile);
        let bytes = kept();
        assert_eq!(surface.piece_count(), pieces, "{name}");
        // The control points of the pieces alone take as much.
        assert!(bytes > 32 * pieces && bytes < MOST, "{name}: {bytes}");
        // No query adds to it.
        let ray = Ray::new(Vec3::new(5.0, 0.01, 0.5), Vec3::new(-1.0, 0.0, 0.02));
        let hit = surface.closest(&ray).unwrap();
        assert!(surface.any(&ray) && surface.interaction(&ray, &hit).point.is_finite());
        assert_eq!(kept(), bytes, "{name}");
        println!("{name}: {bytes} bytes");
    }
}
