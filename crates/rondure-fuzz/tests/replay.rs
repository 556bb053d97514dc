//! Every seed of the fuzz targets, and everything that they found.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::{fs, path::Path};

use rondure_fuzz::TARGETS;

#[test]
fn every_seed_holds() {
    for (name, target) in TARGETS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds").join(name);
        let mut paths: Vec<_> =
            fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        assert!(paths.len() >= 20, "{} seeds for {name}", paths.len());
        for path in paths {
            println!("{}", path.display());
            target(&fs::read(path).unwrap());
        }
    }
}
