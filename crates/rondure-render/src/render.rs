//! From a scene to a picture, in one go.

use core::ops::Range;

use rondure_film::{FilmError, Layers, Room, SpoolError};
use rondure_image::WhiteError;
use rondure_scene::Scene;

use crate::{
    NOISE_BLOCK, Picture,
    job::Job,
    look::look,
    work::{Outcome, Snapshot, Work},
};

/// How to render, beside what the scene says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Settings {
    /// The number of threads; `None` takes all that the machine offers.
    pub threads: Option<usize>,
    /// Chooses the random numbers. The same seed gives the same picture, bit for bit, on any
    /// number of threads.
    pub seed: u64,
}

/// Someone who waits for the picture. Called from any thread, in the middle of the work.
pub trait Progress: Sync {
    /// `done` (from 0 to 1) of all samples are taken; it may come out of order.
    fn advance(&self, done: f64) {
        let _ = done;
    }

    /// Of what is made before a pass (photons), `done` (from 0 to 1) is; it may come out of order.
    fn preparing(&self, done: f64) {
        let _ = done;
    }

    /// Whether to stop at once. Asked once for each row of a tile; a tile in the making is given up.
    fn is_cancelled(&self) -> bool {
        false
    }

    /// Whether to stop when the tiles in the making are done. Asked before each tile, and while what is made before a pass is made.
    fn is_enough(&self) -> bool {
        false
    }

    /// Another tile is done, and these are the sums so far. Called by one thread at a time; the others wait with their tiles.
    fn landed(&self, so_far: &Snapshot<'_>) {
        let _ = so_far;
    }
}

/// Nobody waits.
impl Progress for () {}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The work was stopped.
    #[error("the rendering was cancelled")]
    Cancelled,
    /// The film has no pixels or no samples.
    #[error("a picture of {width}x{height} pixels with {spp} samples each has nothing to render")]
    EmptyFilm {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Samples in each pixel.
        spp: u32,
    },
    /// The picture does not fit into memory.
    #[error("a picture of {width}x{height} pixels does not fit into memory")]
    TooLarge {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// The film cannot take what it is to take.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// The sums cannot be kept in a scratch file.
    #[error(transparent)]
    Sums(SpoolError),
    /// Samples were asked for that are not of the pass.
    #[error("samples {samples:?} are not all of the pass of samples {pass:?}")]
    OtherPass {
        /// The numbers of the samples that were asked for.
        samples: Range<u32>,
        /// The numbers of the samples of the pass.
        pass: Range<u32>,
    },
    /// A share cannot be gone on with as this work.
    #[error("the share is of another portion of the picture, or has other layers or tiles")]
    OtherPortion,
    /// The camera cannot see.
    #[error(
        "the camera sees nothing: eye and look_at must differ, up must not be parallel to the \
         view, and the field of view or height must be positive"
    )]
    Camera,
    /// An object refers to a material that is not there.
    #[error("object {object:?} has material {material}, but the scene has {materials}")]
    NoSuchMaterial {
        /// The object's name.
        object: String,
        /// The index that it refers to.
        material: usize,
        /// How many materials there are.
        materials: usize,
    },
    /// An object cannot stand where it is placed.
    #[error("object {object:?} cannot be placed: {source}")]
    Placement {
        /// The object's name.
        object: String,
        /// Why not.
        source: rondure::PlaceError,
    },
    /// A solid cannot be made, or not where it is placed or cut.
    #[error("object {object:?} cannot be made: {source}")]
    Solid {
        /// The object's name.
        object: String,
        /// Why not.
        source: rondure::solid::CsgError,
    },
    /// The objects do not fit into memory.
    #[error("{count} turned objects do not fit into memory; each takes some 300 bytes")]
    OutOfMemory {
        /// How many there are.
        count: u64,
    },
    /// There are too many objects.
    #[error("a scene can have at most 2 billion objects and lights: {0}")]
    TooManyObjects(#[from] rondure::bvh::TooManyItems),
    /// A limit of noise needs to know the noise.
    #[error("a picture without a layer of variance has no limit of noise")]
    NoVariance,
    /// Only whole blocks with all their samples can be judged by their noise.
    #[error(
        "a limit of noise is for parts of whole blocks of {NOISE_BLOCK}x{NOISE_BLOCK} pixels with all their samples"
    )]
    NoisePart,
    /// No light has the colour that is to look white.
    #[error(transparent)]
    White(#[from] WhiteError),
    /// The threads could not be started.
    #[error("cannot start the threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

impl From<SpoolError> for RenderError {
    fn from(error: SpoolError) -> Self {
        match error {
            SpoolError::Film(error) => Self::Film(error),
            other => Self::Sums(other),
        }
    }
}

/// Renders a scene.
///
/// # Errors
/// If the scene cannot be rendered (see [`RenderError`]), or `progress` asks to stop.
pub fn render(
    scene: &Scene,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Picture, RenderError> {
    let look = look(&scene.film)?;
    let job = Job::new(scene, settings, Layers::default())?;
    let mut work = Work::new(&job, job.whole(), &Room::default())?;
    match work.run(&job, settings.threads, progress)? {
        Outcome::Finished => Ok(Picture::new(&*work.sums().film()?, look, *work.statistics())),
        Outcome::Stopped => Err(RenderError::Cancelled),
    }
}
