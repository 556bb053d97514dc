//! What crosses the border to Embree 4.4: its structures and numbers, as its headers
//! `include/embree4/rtcore_*.h` declare them, in its default configuration (one level of instances,
//! instance arrays, no minimal width).

use std::ffi::c_void;

pub(super) type Device = *mut c_void;
pub(super) type Scene = *mut c_void;
pub(super) type Geometry = *mut c_void;

/// `RTC_INVALID_GEOMETRY_ID`: no hit.
pub(super) const INVALID: u32 = u32::MAX;
/// `RTC_BUILD_QUALITY_HIGH`: with spatial splits.
pub(super) const QUALITY_HIGH: u32 = 2;
/// `RTC_FEATURE_FLAG_ALL`
pub(super) const FEATURES_ALL: u32 = u32::MAX;
/// `RTC_RAY_QUERY_FLAG_COHERENT`
pub(super) const COHERENT: u32 = 1 << 16;

/// `RTCGeometryType`
pub(super) const TRIANGLES: u32 = 0;
pub(super) const QUADS: u32 = 1;
pub(super) const GRIDS: u32 = 2;
pub(super) const INSTANCE: u32 = 121;

/// `RTCBufferType`
pub(super) const BUFFER_INDEX: u32 = 0;
pub(super) const BUFFER_VERTEX: u32 = 1;
pub(super) const BUFFER_GRID: u32 = 8;

/// `RTCFormat`
pub(super) const UINT3: u32 = 0x5003;
pub(super) const UINT4: u32 = 0x5004;
pub(super) const FLOAT3: u32 = 0x9003;
pub(super) const FLOAT3X4_ROW_MAJOR: u32 = 0x9134;
pub(super) const GRID: u32 = 0xA001;

/// `RTCDeviceProperty`: version as major * 10,000 + minor * 100 + patch.
pub(super) const PROPERTY_VERSION: u32 = 0;
/// `RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED`: packets of 16 are traced as such (AVX-512).
pub(super) const PROPERTY_NATIVE_RAY16: u32 = 34;

/// `RTCRay`
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub(super) struct Ray {
    pub(super) origin: [f32; 3],
    pub(super) near: f32,
    pub(super) direction: [f32; 3],
    pub(super) time: f32,
    pub(super) far: f32,
    pub(super) mask: u32,
    pub(super) id: u32,
    pub(super) flags: u32,
}

/// `RTCHit`
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub(super) struct Hit {
    pub(super) normal: [f32; 3],
    pub(super) uv: [f32; 2],
    pub(super) primitive: u32,
    pub(super) geometry: u32,
    pub(super) instance: u32,
    pub(super) instance_primitive: u32,
}

/// `RTCRayHit`
#[derive(Clone, Copy)]
#[repr(C)]
pub(super) struct RayHit {
    pub(super) ray: Ray,
    pub(super) hit: Hit,
}

/// `RTCRay16`
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Ray16 {
    pub(super) origin: [[f32; 16]; 3],
    pub(super) near: [f32; 16],
    pub(super) direction: [[f32; 16]; 3],
    pub(super) time: [f32; 16],
    pub(super) far: [f32; 16],
    pub(super) mask: [u32; 16],
    pub(super) id: [u32; 16],
    pub(super) flags: [u32; 16],
}

/// `RTCHit16`
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Hit16 {
    pub(super) normal: [[f32; 16]; 3],
    pub(super) uv: [[f32; 16]; 2],
    pub(super) primitive: [u32; 16],
    pub(super) geometry: [u32; 16],
    pub(super) instance: [u32; 16],
    pub(super) instance_primitive: [u32; 16],
}

/// `RTCRayHit16`
#[derive(Clone, Copy)]
#[repr(C)]
pub(super) struct RayHit16 {
    pub(super) ray: Ray16,
    pub(super) hit: Hit16,
}

/// `RTCRayQueryContext`
#[repr(C)]
pub(super) struct Context {
    pub(super) instance: u32,
    pub(super) instance_primitive: u32,
}

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which have the same fields.
#[repr(C)]
pub(super) struct Arguments {
    pub(super) flags: u32,
    pub(super) features: u32,
    pub(super) context: *mut Context,
    pub(super) filter: *mut c_void,
    pub(super) user: *mut c_void,
}

/// `RTCGrid`
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Grid {
    /// The first vertex.
    pub(crate) start: u32,
    /// How many vertices further the next row begins.
    pub(crate) stride: u32,
    /// Vertices in a row.
    pub(crate) width: u16,
    /// Rows.
    pub(crate) height: u16,
}

/// `RTCMemoryMonitorFunction`
pub(super) type MemoryMonitor = extern "C" fn(*mut c_void, isize, bool) -> bool;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_those_of_the_headers() {
        assert_eq!(size_of::<Ray>(), 48);
        assert_eq!(size_of::<Hit>(), 48);
        assert_eq!(size_of::<RayHit>(), 96);
        assert_eq!(size_of::<RayHit16>(), (12 + 9) * 64);
        assert_eq!(align_of::<RayHit16>(), 64);
        assert_eq!(size_of::<Arguments>(), 32);
        assert_eq!(size_of::<Grid>(), 12);
    }
}
