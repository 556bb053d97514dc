//! Wood that was turned from a log: rings in space round a pith, in the manner of Peachey 1985, "Solid Texturing of
//! Complex Surfaces", with what makes them wood.
//!
//! Across the grain a ring is light where it grew in spring and darkens towards its end, where it breaks off;
//! rings are not round, and not of the same width. Along the grain everything is drawn out: fibres, the pores
//! of the early wood, and the flecks of the rays, which stand upright and run from the pith outwards.

use core::f64::consts::TAU;

use rondure::Vec3;
use rondure_scene::Wood as Described;

use super::{
    Spot,
    noise::{noise, random, turbulence},
};
use crate::{color::Rgb, warp::Frame};

/// Wood, ready to be looked up.
#[derive(Clone, Debug)]
pub(crate) struct Wood {
    early: Rgb,
    late: Rgb,
    pith: Vec3,
    /// z along the grain.
    grain: Frame,
    per_ring: f64,
    wobble: f64,
    fibre: f64,
    pores: f64,
    rays: f64,
    seed: Option<u32>,
}

impl Wood {
    pub(super) fn new(wood: &Described) -> Self {
        Self {
            early: wood.early.into(),
            late: wood.late.into(),
            pith: wood.pith,
            grain: Frame::new(wood.axis),
            per_ring: 1.0 / wood.ring,
            wobble: wood.wobble,
            fibre: wood.fibre,
            pores: wood.pores,
            rays: wood.rays,
            seed: wood.seed,
        }
    }

    pub(super) fn at(&self, spot: &Spot) -> Rgb {
        let mut log = self.grain.to_local(spot.point - self.pith) * self.per_ring;
        let mut seed = 0;
        if let Some(own) = self.seed {
            // Another length of the log, another side of the pith.
            seed = spot.seed(own);
            let (sin, cos) = (TAU * random(1, seed)).sin_cos();
            log = Vec3::new(cos * log.x - sin * log.y, sin * log.x + cos * log.y, log.z);
            log.z += 1000.0 * random(2, seed);
        }
        self.in_log(log, seed)
    }

    /// The colour in the frame of the log, in widths of a ring.
    fn in_log(&self, p: Vec3, seed: u32) -> Rgb {
        // A tree changes its shape slowly, and more so across than along.
        let drawn = |across: f64, along: f64| Vec3::new(p.x * across, p.y * across, p.z * along);
        let bent = self.wobble * turbulence(drawn(0.12, 0.012), 3, seed);
        let radius = p.x.hypot(p.y);
        // Years differ; the rings stay in order, for the slope of what is added is below 1.
        let years = radius + bent;
        let years = years + 0.35 * noise(Vec3::new(0.5, 0.5, years * 0.7), seed.wrapping_add(11));
        let (ring, within) = (years.floor(), years - years.floor());
        let year = random(ring as i64 as u32, seed.wrapping_add(12));
        // Late wood: it comes on slowly, and ends within a twentieth of the ring.
        let late = smooth(0.35 + 0.2 * year, 0.92, within) * (1.0 - smooth(0.95, 1.0, within));
        let mut color = self.early.mix(self.late, late * (0.65 + 0.35 * year));

        let fibre = turbulence(drawn(4.0, 0.09), 2, seed.wrapping_add(13));
        color = color * (1.0 + 0.3 * self.fibre * fibre);

        // Pores are short dark dashes, most of them in the early wood.
        let dash = noise(drawn(7.0, 0.55), seed.wrapping_add(14));
        let pore = smooth(0.32, 0.5, dash) * (1.0 - 0.8 * late);
        color = color * (1.0 - 0.65 * self.pores * pore);

        // Sheets along the radius, thin round the pith and a few rings deep and high.
        let angle = p.y.atan2(p.x);
        let sheet = Vec3::new(angle.cos() * 40.0, angle.sin() * 40.0, p.z * 0.35 + radius * 0.09);
        let fleck = smooth(0.42, 0.58, noise(sheet, seed.wrapping_add(15)));
        let bright = self.early.map(|c| (1.25 * c + 0.04).min(1.0));
        color.mix(bright, self.rays * fleck).map(|c| c.clamp(0.0, 1.0))
    }
}

/// From 0 at `from` to 1 at `to`, without a kink.
fn smooth(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain() -> Described {
        Described {
            early: [0.8; 3],
            late: [0.2; 3],
            pith: Vec3::new(1.0, 2.0, 0.0),
            axis: Vec3::Z,
            ring: 0.1,
            wobble: 0.0,
            fibre: 0.0,
            pores: 0.0,
            rays: 0.0,
            seed: None,
        }
    }

    fn spot(point: Vec3, copy: u32) -> Spot {
        Spot { point, copy, ..Spot::default() }
    }

    #[test]
    fn without_wobble_rings_are_round_and_straight() {
        let wood = Wood::new(&plain());
        let mut changes = 0;
        let mut last = wood.at(&spot(Vec3::new(1.0, 2.0, 0.0), 0)).r;
        for i in 1..2000 {
            let radius = f64::from(i) * 1e-3;
            let at = |angle: f64, z: f64| {
                let (sin, cos) = angle.sin_cos();
                wood.at(&spot(Vec3::new(1.0 + radius * cos, 2.0 + radius * sin, z), 0)).r
            };
            let here = at(0.3, 0.0);
            for (angle, z) in [(1.0, 0.0), (2.5, -3.0), (5.0, 7.0)] {
                assert!((at(angle, z) - here).abs() < 1e-9, "{radius}");
            }
            assert!((0.2..=0.8).contains(&here));
            // Early wood begins where the late wood breaks off.
            changes += u32::from(last < 0.5 && here >= 0.5);
            last = here;
        }
        assert!((18..=22).contains(&changes), "{changes} rings in 20 widths");
    }

    #[test]
    fn copies_differ_if_they_shall() {
        let mut described = plain();
        (described.wobble, described.fibre) = (1.0, 0.5);
        let place = Vec3::new(0.3, 0.4, 0.5);
        let same = Wood::new(&described);
        assert_eq!(same.at(&spot(place, 1)), same.at(&spot(place, 2)));
        described.seed = Some(3);
        let other = Wood::new(&described);
        let colors: Vec<_> = (0..8).map(|copy| other.at(&spot(place, copy)).r).collect();
        assert_eq!(colors[3], other.at(&spot(place, 3)).r);
        assert!(colors.windows(2).filter(|c| c[0] != c[1]).count() >= 6, "{colors:?}");
    }
}
