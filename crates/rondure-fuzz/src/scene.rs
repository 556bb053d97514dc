//! Scenes: whatever the text, there is a scene or a report, and either can be shown.

use std::path::Path;

use rondure_scene::parse_scene;

use crate::check_report;

/// The text of a scene. One that refers to files elsewhere is left alone: what stands in a device
/// or at the other end of a pipe is nobody's promise.
pub fn scene(data: &[u8]) {
    let Ok(text) = core::str::from_utf8(data) else { return };
    let elsewhere = ["file", "image", "bump", "map"].iter().any(|key| text.contains(key));
    if elsewhere && text.contains(['/', '\\']) {
        return;
    }
    match parse_scene("fuzz", text, Path::new("no-such-folder")) {
        Ok((scene, warnings)) => {
            assert_eq!(warnings.errors(), 0, "an error, and yet a scene");
            if !warnings.is_empty() {
                check_report(&warnings);
            }
            for object in &scene.objects {
                assert!(object.material < scene.materials.len(), "no such material");
            }
        }
        Err(report) => {
            assert!(report.errors() > 0, "refused without an error");
            check_report(&report);
        }
    }
}
