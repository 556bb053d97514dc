//! The figures and the report.

use std::fs;

use rondure_paper::{Options, figures, measure};

#[test]
fn figures_are_whole() {
    for (name, text) in figures::all() {
        assert!(text.starts_with("<svg ") && text.ends_with("</svg>\n"), "{name}");
        assert!(text.matches("<path").count() > 10, "{name} is almost empty");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{name}");
    }
}

#[test]
fn small_pictures_agree_bit_for_bit_and_everything_is_written() {
    let options = Options { size: 24, repetitions: 1, samples: 200, ..Options::default() };
    let report = measure(&options, &()).unwrap();
    assert_eq!(report.measured.len(), 2);
    for scene in &report.measured {
        assert_eq!(scene.different_pictures, 0);
        assert!(scene.difference_to_exact < 0.05, "{}", scene.difference_to_exact);
        for run in &scene.runs {
            assert!(run.work.leaf_solves > 0 && run.best() > 0.0);
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let files = report.write(&folder.path().join("new")).unwrap();
    assert_eq!(files.len(), 8);
    let lines = fs::read_to_string(folder.path().join("new/tables.csv")).unwrap().lines().count();
    assert_eq!(lines, 1 + report.measured.iter().map(|scene| scene.runs.len()).sum::<usize>());
}
