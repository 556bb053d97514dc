//! Embree 4.4, loaded at run time, behind a safe face: a [`Device`], its [`Scene`]s, and the four
//! queries that the race needs, each over a whole list of rays.
//!
//! The only module of this crate with unsafe code. What it rests on: the library is Embree 4
//! (checked when it is loaded), and `abi.rs` describes its default configuration.

#![allow(unsafe_code, reason = "Embree is a C library")]

use std::error::Error;
use std::ffi::{CStr, CString, c_char, c_void};
use std::path::Path;
use std::ptr;
use std::sync::atomic::{AtomicI64, Ordering::Relaxed};

use libloading::os::unix::{Library, RTLD_GLOBAL, RTLD_NOW};
use rondure::Affine;

use super::abi::{self, Arguments, Context, INVALID, Ray, Ray16, RayHit, RayHit16};
use super::mesh::{Buffers, Primitives};

/// A ray in single precision, without its range.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Single {
    pub(crate) origin: [f32; 3],
    pub(crate) direction: [f32; 3],
}

/// Sixteen such rays, coordinate by coordinate.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Packet {
    pub(crate) origin: [[f32; 16]; 3],
    pub(crate) direction: [[f32; 16]; 3],
}

/// Rays in packets. Lanes after the last ray are not traced.
#[derive(Clone, Debug)]
pub(crate) struct Packets {
    packets: Vec<Packet>,
    len: usize,
}

impl Packets {
    pub(crate) fn new(rays: &[Single]) -> Self {
        let packet = |rays: &[Single]| {
            let lane = |i: usize| rays[i.min(rays.len() - 1)];
            let lanes = |of: fn(Single) -> [f32; 3]| {
                [0, 1, 2].map(|axis| std::array::from_fn(|i| of(lane(i))[axis]))
            };
            Packet { origin: lanes(|ray| ray.origin), direction: lanes(|ray| ray.direction) }
        };
        Self { packets: rays.chunks(16).map(packet).collect(), len: rays.len() }
    }

    /// Each packet with the lanes to trace.
    fn iter(&self) -> impl Iterator<Item = (&Packet, Valid)> {
        self.packets.iter().enumerate().map(|(i, packet)| (packet, Valid::first(self.len - 16 * i)))
    }
}

/// A mask of lanes: -1 where there is a ray.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Valid([i32; 16]);

impl Valid {
    #[inline]
    fn first(lanes: usize) -> Self {
        const ALL: Valid = Valid([-1; 16]);
        if lanes >= 16 { ALL } else { Self(std::array::from_fn(|i| -i32::from(i < lanes))) }
    }
}

/// The functions of the library that are used here.
macro_rules! functions {
    ($($field:ident = $name:literal ($($argument:ty),*) $(-> $result:ty)?;)*) => {
        struct Functions {
            $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            /// # Safety
            ///
            /// The library must be Embree 4, and must outlive what is returned.
            unsafe fn load(library: &Library) -> Result<Self, libloading::Error> {
                Ok(Self {
                    // SAFETY: the types are those of Embree's headers.
                    $($field: *unsafe { library.get($name.as_bytes()) }?,)*
                })
            }
        }
    };
}

functions! {
    new_device = "rtcNewDevice" (*const c_char) -> abi::Device;
    release_device = "rtcReleaseDevice" (abi::Device);
    property = "rtcGetDeviceProperty" (abi::Device, u32) -> isize;
    last_error = "rtcGetDeviceLastErrorMessage" (abi::Device) -> *const c_char;
    error = "rtcGetDeviceError" (abi::Device) -> u32;
    monitor_memory = "rtcSetDeviceMemoryMonitorFunction" (abi::Device, abi::MemoryMonitor, *mut c_void);
    new_scene = "rtcNewScene" (abi::Device) -> abi::Scene;
    release_scene = "rtcReleaseScene" (abi::Scene);
    scene_quality = "rtcSetSceneBuildQuality" (abi::Scene, u32);
    commit_scene = "rtcCommitScene" (abi::Scene);
    attach = "rtcAttachGeometry" (abi::Scene, abi::Geometry) -> u32;
    new_geometry = "rtcNewGeometry" (abi::Device, u32) -> abi::Geometry;
    release_geometry = "rtcReleaseGeometry" (abi::Geometry);
    commit_geometry = "rtcCommitGeometry" (abi::Geometry);
    new_buffer = "rtcSetNewGeometryBuffer" (abi::Geometry, u32, u32, u32, usize, usize) -> *mut c_void;
    instanced_scene = "rtcSetGeometryInstancedScene" (abi::Geometry, abi::Scene);
    transform = "rtcSetGeometryTransform" (abi::Geometry, u32, u32, *const c_void);
    intersect1 = "rtcIntersect1" (abi::Scene, *mut RayHit, *mut Arguments);
    intersect16 = "rtcIntersect16" (*const i32, abi::Scene, *mut RayHit16, *mut Arguments);
    occluded1 = "rtcOccluded1" (abi::Scene, *mut Ray, *mut Arguments);
    occluded16 = "rtcOccluded16" (*const i32, abi::Scene, *mut Ray16, *mut Arguments);
}

/// Embree, on one thread.
pub(crate) struct Device {
    functions: Functions,
    device: abi::Device,
    /// What Embree has allocated and not freed, in bytes; told by [`count_memory`].
    memory: Box<AtomicI64>,
    /// Last, so that it is closed last.
    _library: Library,
}

impl Device {
    /// Loads the library in a file, after those it needs.
    pub(crate) fn load(library: &Path, needs: &[impl AsRef<Path>]) -> Result<Self, Box<dyn Error>> {
        for needed in needs {
            // SAFETY: TBB's initialisation has no preconditions. It is never unloaded.
            let needed = unsafe { Library::open(Some(needed.as_ref()), RTLD_NOW | RTLD_GLOBAL) }?;
            std::mem::forget(needed);
        }
        // SAFETY: Embree's initialisation has no preconditions; the functions live as long as the
        // library, which the device keeps.
        let (library, functions) = unsafe {
            let library = Library::open(Some(library), RTLD_NOW)?;
            let functions = Functions::load(&library)?;
            (library, functions)
        };
        let config = CString::new(CONFIG)?;
        // SAFETY: the string lives through the call.
        let device = unsafe { (functions.new_device)(config.as_ptr()) };
        if device.is_null() {
            return Err("Embree finds no device: it needs an x86-64 processor with SSE 4.2".into());
        }
        let memory = Box::new(AtomicI64::new(0));
        let counter = ptr::from_ref(&*memory).cast_mut().cast();
        // SAFETY: the counter is dropped after the device is released.
        unsafe { (functions.monitor_memory)(device, count_memory, counter) };
        let this = Self { functions, device, memory, _library: library };
        let version = this.property(abi::PROPERTY_VERSION);
        if version / 10_000 != 4 {
            return Err(format!("this library is not Embree 4, but version {version}").into());
        }
        Ok(this)
    }

    fn property(&self, property: u32) -> isize {
        // SAFETY: the device is valid.
        unsafe { (self.functions.property)(self.device, property) }
    }

    /// The version and how wide its packets are.
    pub(crate) fn describe(&self) -> String {
        let version = self.property(abi::PROPERTY_VERSION);
        let packets = if self.property(abi::PROPERTY_NATIVE_RAY16) > 0 {
            "AVX-512, packets of 16"
        } else {
            "no AVX-512: packets of 16 are split"
        };
        let (major, minor, patch) = (version / 10_000, version / 100 % 100, version % 100);
        format!("Embree {major}.{minor}.{patch} ({packets})")
    }

    /// Bytes that Embree has allocated and not freed.
    pub(crate) fn memory(&self) -> i64 {
        self.memory.load(Relaxed)
    }

    /// Builds a scene of one mesh.
    pub(crate) fn mesh(&self, mesh: &Buffers) -> Result<Scene<'_>, Box<dyn Error>> {
        let Functions { new_geometry, commit_geometry, .. } = &self.functions;
        let kind = match mesh.primitives {
            Primitives::Triangles(_) => abi::TRIANGLES,
            Primitives::Quads(_) => abi::QUADS,
            Primitives::Grids(_) => abi::GRIDS,
        };
        // SAFETY: the device is valid.
        let geometry = unsafe { new_geometry(self.device, kind) };
        self.fill(geometry, abi::BUFFER_VERTEX, abi::FLOAT3, &mesh.vertices)?;
        match &mesh.primitives {
            Primitives::Triangles(list) => self.fill(geometry, abi::BUFFER_INDEX, abi::UINT3, list),
            Primitives::Quads(list) => self.fill(geometry, abi::BUFFER_INDEX, abi::UINT4, list),
            Primitives::Grids(list) => self.fill(geometry, abi::BUFFER_GRID, abi::GRID, list),
        }?;
        // SAFETY: the geometry is valid and has its buffers.
        unsafe { commit_geometry(geometry) };
        self.scene([geometry])
    }

    /// Builds a scene of copies of another.
    pub(crate) fn instances<'a>(
        &'a self,
        model: &Scene<'a>,
        placements: &[Affine],
    ) -> Result<Scene<'a>, Box<dyn Error>> {
        let geometries = placements.iter().map(|placement| {
            let [x, y, z] = placement.columns;
            let t = placement.translation;
            let row = |[x, y, z, t]: [f64; 4]| [x as f32, y as f32, z as f32, t as f32];
            let rows =
                [row([x.x, y.x, z.x, t.x]), row([x.y, y.y, z.y, t.y]), row([x.z, y.z, z.z, t.z])];
            // SAFETY: device and model are valid, the geometry retains the model, and the matrix is
            // copied.
            unsafe {
                let geometry = (self.functions.new_geometry)(self.device, abi::INSTANCE);
                (self.functions.instanced_scene)(geometry, model.scene);
                let format = abi::FLOAT3X4_ROW_MAJOR;
                (self.functions.transform)(geometry, 0, format, rows.as_ptr().cast());
                (self.functions.commit_geometry)(geometry);
                geometry
            }
        });
        self.scene(geometries)
    }

    fn fill<T: Copy>(
        &self,
        geometry: abi::Geometry,
        buffer: u32,
        format: u32,
        list: &[T],
    ) -> Result<(), Box<dyn Error>> {
        let (stride, count) = (size_of::<T>(), list.len());
        // SAFETY: the geometry is valid. The new buffer, if there is one, has room for the list.
        unsafe {
            let to = (self.functions.new_buffer)(geometry, buffer, 0, format, stride, count);
            if !to.is_null() {
                ptr::copy_nonoverlapping(list.as_ptr(), to.cast(), count);
            }
        }
        self.check()
    }

    fn scene(
        &self,
        geometries: impl IntoIterator<Item = abi::Geometry>,
    ) -> Result<Scene<'_>, Box<dyn Error>> {
        // SAFETY: device and geometries are valid. The scene retains what is attached to it.
        let scene = unsafe {
            let scene = (self.functions.new_scene)(self.device);
            (self.functions.scene_quality)(scene, abi::QUALITY_HIGH);
            for geometry in geometries {
                (self.functions.attach)(scene, geometry);
                (self.functions.release_geometry)(geometry);
            }
            (self.functions.commit_scene)(scene);
            scene
        };
        let scene = Scene { device: self, scene };
        self.check()?;
        Ok(scene)
    }

    fn check(&self) -> Result<(), Box<dyn Error>> {
        // SAFETY: the device is valid; the message is that of its last error.
        unsafe {
            let message = (self.functions.last_error)(self.device);
            if (self.functions.error)(self.device) == 0 {
                return Ok(());
            }
            let message = if message.is_null() { c"no message" } else { CStr::from_ptr(message) };
            Err(format!("Embree: {}", message.to_string_lossy()).into())
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: scenes borrow the device, so none is left.
        unsafe { (self.functions.release_device)(self.device) };
    }
}

/// One thread, and the widest registers that the processor has.
const CONFIG: &str = "threads=1,user_threads=0,frequency_level=simd512";

extern "C" fn count_memory(counter: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: the pointer is to the counter of a living device.
    let counter = unsafe { &*counter.cast::<AtomicI64>() };
    counter.fetch_add(bytes as i64, Relaxed);
    true
}

/// What rays can be sent into.
pub(crate) struct Scene<'a> {
    device: &'a Device,
    scene: abi::Scene,
}

impl Scene<'_> {
    /// How many rays hit between 0 and `far`.
    pub(crate) fn closest(&self, rays: &[Single], far: f32) -> u64 {
        let mut context = NO_CONTEXT;
        let mut arguments = arguments(&mut context, false);
        let mut hits = 0;
        let intersect1 = self.device.functions.intersect1;
        let _flushed = Flushed::new();
        let mut query = RayHit { ray: NO_RAY, hit: NO_HIT };
        for ray in rays {
            query.ray = query_ray(ray, far);
            query.hit.geometry = INVALID;
            // SAFETY: all pointers are to living, aligned structures.
            unsafe { intersect1(self.scene, &raw mut query, &raw mut arguments) };
            hits += u64::from(query.hit.geometry != INVALID);
        }
        hits
    }

    /// How many rays hit anything between 0 and `far`.
    pub(crate) fn any(&self, rays: &[Single], far: f32) -> u64 {
        let mut context = NO_CONTEXT;
        let mut arguments = arguments(&mut context, false);
        let mut hits = 0;
        let occluded1 = self.device.functions.occluded1;
        let _flushed = Flushed::new();
        for ray in rays {
            let mut query = query_ray(ray, far);
            // SAFETY: all pointers are to living, aligned structures.
            unsafe { occluded1(self.scene, &raw mut query, &raw mut arguments) };
            hits += u64::from(query.far < 0.0);
        }
        hits
    }

    /// As [`closest`](Self::closest), sixteen at a time.
    pub(crate) fn closest_packets(&self, rays: &Packets, far: f32, coherent: bool) -> u64 {
        let mut context = NO_CONTEXT;
        let mut arguments = arguments(&mut context, coherent);
        let mut hits = 0;
        let intersect16 = self.device.functions.intersect16;
        let _flushed = Flushed::new();
        let mut query = RayHit16 { ray: NO_RAY_16, hit: NO_HIT_16 };
        for (packet, valid) in rays.iter() {
            load_packet(&mut query.ray, packet, far);
            query.hit.geometry = [INVALID; 16];
            // SAFETY: all pointers are to living, aligned structures.
            unsafe {
                intersect16(valid.0.as_ptr(), self.scene, &raw mut query, &raw mut arguments);
            }
            hits += query.hit.geometry.iter().map(|&g| u64::from(g != INVALID)).sum::<u64>();
        }
        hits
    }

    /// As [`any`](Self::any), sixteen at a time.
    pub(crate) fn any_packets(&self, rays: &Packets, far: f32, coherent: bool) -> u64 {
        let mut context = NO_CONTEXT;
        let mut arguments = arguments(&mut context, coherent);
        let mut hits = 0;
        let occluded16 = self.device.functions.occluded16;
        let _flushed = Flushed::new();
        let mut query = NO_RAY_16;
        for (packet, valid) in rays.iter() {
            load_packet(&mut query, packet, far);
            // SAFETY: all pointers are to living, aligned structures.
            unsafe {
                occluded16(valid.0.as_ptr(), self.scene, &raw mut query, &raw mut arguments);
            }
            hits += query.far.iter().map(|&far| u64::from(far < 0.0)).sum::<u64>();
        }
        hits
    }

    /// Which of the rays hit.
    pub(crate) fn hits<'a>(
        &'a self,
        rays: &'a [Single],
        far: f32,
    ) -> impl Iterator<Item = bool> + 'a {
        rays.iter().map(move |ray| self.closest(std::slice::from_ref(ray), far) == 1)
    }
}

impl Drop for Scene<'_> {
    fn drop(&mut self) {
        // SAFETY: the device outlives the scene.
        unsafe { (self.device.functions.release_scene)(self.scene) };
    }
}

#[inline]
fn arguments(context: &mut Context, coherent: bool) -> Arguments {
    Arguments {
        flags: if coherent { abi::COHERENT } else { 0 },
        features: abi::FEATURES_ALL,
        context,
        filter: ptr::null_mut(),
        user: ptr::null_mut(),
    }
}

#[inline]
fn query_ray(ray: &Single, far: f32) -> Ray {
    Ray { origin: ray.origin, direction: ray.direction, far, ..NO_RAY }
}

#[inline]
fn load_packet(query: &mut Ray16, packet: &Packet, far: f32) {
    query.origin = packet.origin;
    query.direction = packet.direction;
    query.far = [far; 16];
}

const NO_CONTEXT: Context = Context { instance: INVALID, instance_primitive: INVALID };

const NO_RAY: Ray = Ray {
    origin: [0.0; 3],
    near: 0.0,
    direction: [0.0; 3],
    time: 0.0,
    far: 0.0,
    mask: u32::MAX,
    id: 0,
    flags: 0,
};

const NO_HIT: abi::Hit = abi::Hit {
    normal: [0.0; 3],
    uv: [0.0; 2],
    primitive: INVALID,
    geometry: INVALID,
    instance: INVALID,
    instance_primitive: INVALID,
};

const NO_RAY_16: Ray16 = Ray16 {
    origin: [[0.0; 16]; 3],
    near: [0.0; 16],
    direction: [[0.0; 16]; 3],
    time: [0.0; 16],
    far: [0.0; 16],
    mask: [u32::MAX; 16],
    id: [0; 16],
    flags: [0; 16],
};

const NO_HIT_16: abi::Hit16 = abi::Hit16 {
    normal: [[0.0; 16]; 3],
    uv: [[0.0; 16]; 2],
    primitive: [INVALID; 16],
    geometry: [INVALID; 16],
    instance: [INVALID; 16],
    instance_primitive: [INVALID; 16],
};

/// While it lives, this thread takes denormal numbers for zero, as Embree's manual advises.
struct Flushed {
    before: u32,
}

impl Flushed {
    /// Flush to zero, and denormals are zero.
    const BITS: u32 = 0x8040;

    fn new() -> Self {
        let before = read_mxcsr();
        write_mxcsr(before | Self::BITS);
        Self { before }
    }
}

impl Drop for Flushed {
    fn drop(&mut self) {
        write_mxcsr(self.before);
    }
}

fn read_mxcsr() -> u32 {
    let mut value = 0_u32;
    // SAFETY: writes the control register's 4 bytes to `value`.
    unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut value, options(nostack)) };
    value
}

fn write_mxcsr(value: u32) {
    // SAFETY: only the two bits differ from what was there; the Rust code until they are set back
    // copies numbers and compares them with zero and infinity.
    unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const value, options(nostack)) };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_without_a_ray_are_not_traced() {
        let packets = Packets::new(&[Single { origin: [1.0; 3], direction: [1.0; 3] }; 19]);
        let valid: Vec<_> = packets.iter().map(|(_, valid)| valid.0.iter().sum::<i32>()).collect();
        assert_eq!(valid, [-16, -3]);
    }
}
