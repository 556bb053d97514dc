//! How much work went into a picture.

/// How many rays were shot, and what went wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Rays from the camera.
    pub camera_rays: u64,
    /// Reflected and refracted rays.
    pub secondary_rays: u64,
    /// Rays towards lights and sky.
    pub shadow_rays: u64,
    /// Samples that came out negative, infinite, not a number, or brighter than [`LARGEST`](crate::LARGEST), and were left out of the picture.
    pub invalid_samples: u64,
}

impl Statistics {
    /// Adds what somebody else did.
    pub fn add(&mut self, other: &Self) {
        self.camera_rays += other.camera_rays;
        self.secondary_rays += other.secondary_rays;
        self.shadow_rays += other.shadow_rays;
        self.invalid_samples += other.invalid_samples;
    }
}
