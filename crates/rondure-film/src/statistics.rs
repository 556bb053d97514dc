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

impl Statistics {
    /// All numbers, for files.
    pub(crate) fn counters(&self) -> [u64; 4] {
        let Self { camera_rays, secondary_rays, shadow_rays, invalid_samples } = *self;
        [camera_rays, secondary_rays, shadow_rays, invalid_samples]
    }

    /// From all numbers; `None` if there are others.
    pub(crate) fn from_counters(counters: &[u64]) -> Option<Self> {
        let &[camera_rays, secondary_rays, shadow_rays, invalid_samples] = counters else {
            return None;
        };
        Some(Self { camera_rays, secondary_rays, shadow_rays, invalid_samples })
    }
}
