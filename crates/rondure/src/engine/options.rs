//! Which engine to build.

use fearless_simd::Level;

/// How to find the pieces of the profile that a ray may hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The wide engine, the default: the profile's own curves, eight parts of them tested at once.
    Wide,
    /// The exact engine: the profile's own curves, a tree of hybrid shells.
    Exact,
    /// Kajiya's strip tree in the plane (z, rho^2).
    Kj,
    /// The paper's tree with cylinder shells.
    Cy,
    /// The paper's tree with cone shells.
    Co,
    /// The paper's tree with hybrid shells: cone shells in the leaves, and in every other node
    /// whichever of the two the [`Criterion`] prefers.
    Hy,
    /// The paper's tree with box-and-strip shells: `z` and `rho^2` in a box, `rho^2 - p z` in a strip.
    Bs,
}

impl Method {
    /// All methods, with the names that commands and tables give them.
    pub const ALL: [(Self, &str); 7] = [
        (Self::Wide, "wide"),
        (Self::Exact, "exact"),
        (Self::Kj, "kj"),
        (Self::Cy, "cy"),
        (Self::Co, "co"),
        (Self::Hy, "hy"),
        (Self::Bs, "bs"),
    ];

    /// The name in small letters.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(method, _)| *method == self).map_or("", |(_, name)| name)
    }

    /// Whether hits lie on the profile's own curves, not on a polyline.
    pub fn is_exact(self) -> bool {
        matches!(self, Self::Wide | Self::Exact)
    }
}

/// Which vector instructions the wide engine uses. All find the same hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Instructions {
    /// The best that the machine has.
    #[default]
    Auto,
    /// Those that every machine of the kind has: SSE2 on x86-64, NEON on AArch64.
    Portable,
    /// AVX2 and FMA, on x86-64.
    Avx2,
    /// AVX-512 as of Ice Lake and Zen 4, on x86-64.
    Avx512,
}

impl Instructions {
    /// All choices, with the names that commands give them.
    pub const ALL: [(Self, &str); 4] = [
        (Self::Auto, "auto"),
        (Self::Portable, "portable"),
        (Self::Avx2, "avx2"),
        (Self::Avx512, "avx512"),
    ];

    /// Whether this machine has them.
    pub fn are_available(self) -> bool {
        self.level().is_some()
    }

    pub(crate) fn level(self) -> Option<Level> {
        match self {
            Self::Auto => Some(Level::new()),
            Self::Portable => Some(Level::baseline()),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx2 => Level::new().as_avx2().map(Level::Avx2),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx512 => Level::new().as_avx512().map(Level::Avx512),
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            _ => None,
        }
    }
}

/// What a hybrid shell minimises (paper, section 3.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// The area of the shell's section with the half plane, where a cone shell's counts
    /// `cone_weight` times: 1 is the paper's criterion, infinity leaves cylinders in all inner nodes.
    Area {
        /// The factor on the area of cone shells.
        cone_weight: f64,
    },
    /// The intersection interval, on average over lines through the shell.
    Interval,
}

/// Which engine to build, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineOptions {
    /// How pieces are found.
    pub method: Method,
    /// With which vector instructions; where the machine lacks them, with the best that it has. Used by
    /// [`Method::Wide`] only.
    pub instructions: Instructions,
    /// What the hybrid shells of [`Method::Hy`] minimise.
    pub criterion: Criterion,
    /// About how many points the profile is sampled at (see [`Surface::with_engine`]). Not used by
    /// the engines that are [exact](Method::is_exact).
    ///
    /// [`Surface::with_engine`]: crate::Surface::with_engine
    pub samples: u32,
    /// Each monotone interval is halved this many times, into up to 2^subdivide leaves, as far as it
    /// has points; 0 leaves it whole. Strip trees are split until their leaves are no larger. Not
    /// used by the engines that are exact.
    pub subdivide: u32,
    /// Whether the work is counted, see [`Surface::statistics`](crate::Surface::statistics).
    pub counted: bool,
}

impl Default for EngineOptions {
    /// The wide engine, uncounted; for the others 1000 points and 2^4 leaves in each interval.
    fn default() -> Self {
        Self {
            method: Method::Wide,
            instructions: Instructions::Auto,
            criterion: Criterion::Area { cone_weight: 1.0 },
            samples: 1000,
            subdivide: 4,
            counted: false,
        }
    }
}
