//! placeholder
pub fn all() -> Vec<(&'static str, String)> {
    Vec::new()
}
