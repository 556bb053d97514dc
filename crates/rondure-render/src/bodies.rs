//! Bodies: solids made of others, what the section of a scene has cut, and sweeps that are left open.
//!
//! They stand beside [`Things`](crate::things::Things), behind a tree of their own: rays in a scene
//! without any pay nothing for them. A solid answers by its spans; of a sheet those hits count that lie
//! within a region, itself a solid.

use std::{collections::HashMap, sync::Arc};

use rondure::{
    Affine, Bounds, Bvh, FillRule, Hit, Instance, Interaction, Ray, Solid, Surface, Vec3,
    bvh::TooManyItems,
    solid::{Compound, Csg, CsgError, Face, Span, Sweep},
};
use rondure_scene::Section;

use crate::{color::Rgb, finish::Finish, fresnel, shape::Shape};

/// A place on a body.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    /// Of a solid.
    Face(Face),
    /// Of a sheet.
    Sheet(Hit),
}

/// All bodies, by number.
#[derive(Clone, Debug)]
pub(crate) struct Bodies {
    all: Vec<Body>,
    tree: Bvh,
}

#[derive(Clone, Debug)]
struct Body {
    kind: Kind,
    /// The finish of what has none of its own.
    finish: u32,
    clarity: Clarity,
}

#[derive(Clone, Debug)]
enum Kind {
    Solid(Box<Made>),
    Sheet(Box<Sheet>),
}

/// A solid made of others.
#[derive(Clone, Debug)]
struct Made {
    compound: Compound,
    /// The finish of each primitive, if it has one of its own.
    finishes: Vec<Option<u32>>,
    /// The primitives that lend theirs to those that have none: those that are not taken away.
    lenders: Vec<u32>,
}

/// A surface, of which only what lies in a region counts.
#[derive(Clone, Debug)]
struct Sheet {
    base: Base,
    within: Compound,
}

#[derive(Clone, Debug)]
enum Base {
    Turned(Instance),
    Simple(Shape),
}

/// Which faces of a body let light pass.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Clarity {
    None,
    Some,
    All,
}

impl Bodies {
    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    pub(crate) fn bounds(&self, body: u32) -> Bounds {
        self.all[body as usize].bounds()
    }

    /// The finishes of all its faces.
    pub(crate) fn finishes(&self, body: u32) -> impl Iterator<Item = u32> + '_ {
        let body = &self.all[body as usize];
        let own = match &body.kind {
            Kind::Solid(made) => made.finishes.as_slice(),
            Kind::Sheet(_) => &[None],
        };
        own.iter().map(|finish| finish.unwrap_or(body.finish))
    }

    /// Whether the body has an inside.
    pub(crate) fn is_solid(&self, body: u32) -> bool {
        matches!(self.all[body as usize].kind, Kind::Solid(_))
    }

    /// Whether some face lets light pass.
    pub(crate) fn has_clear(&self) -> bool {
        self.all.iter().any(|body| body.clarity != Clarity::None)
    }

    /// The first place at which the ray meets a body, nearer than its end. The ray is shortened to there.
    pub(crate) fn closest(&self, ray: &mut Ray) -> Option<(u32, f64, Place)> {
        let mut best: Option<(u32, f64, Place)> = None;
        self.tree.walk(&{ *ray }, |i| {
            if let Some((t, place)) = self.all[i as usize].closest(ray)
                && best.is_none_or(|best| t < best.1 || i < best.0)
            {
                best = Some((i, t, place));
                ray.t_max = t;
            }
            ray.t_max
        });
        best
    }

    /// Whether the ray meets any body.
    pub(crate) fn any(&self, ray: &Ray) -> bool {
        let mut found = false;
        self.tree.walk(ray, |i| {
            found = self.all[i as usize].any(ray);
            if found { f64::NEG_INFINITY } else { ray.t_max }
        });
        found
    }

    /// The finish at a place, at this point of the world.
    pub(crate) fn finish_at(&self, body: u32, place: &Place, point: Vec3) -> u32 {
        self.all[body as usize].finish_at(place, point)
    }

    pub(crate) fn interaction(&self, body: u32, ray: &Ray, place: &Place) -> Interaction {
        match (&self.all[body as usize].kind, place) {
            (Kind::Solid(made), Place::Face(face)) => made.compound.interaction(ray, face),
            (Kind::Sheet(sheet), Place::Sheet(hit)) => sheet.interaction(ray, hit),
            // A place comes from `closest`, with the number of the body that it is on.
            _ => unreachable!("a place on another body"),
        }
    }

    /// Whether something that is not clear stands in the ray's range.
    pub(crate) fn blocks(&self, ray: &Ray, finishes: &[Finish]) -> bool {
        let mut blocked = false;
        self.tree.walk(ray, |i| {
            blocked = self.all[i as usize].blocks(ray, finishes);
            if blocked { f64::NEG_INFINITY } else { ray.t_max }
        });
        blocked
    }

    /// The share of the light that passes the surfaces of glass in the ray's range, and the optical
    /// depth inside.
    pub(crate) fn clear(&self, ray: &Ray, finishes: &[Finish]) -> (f64, Rgb) {
        // In the order of their numbers, so that sums do not depend on the tree.
        let mut met = Vec::new();
        self.tree.walk(ray, |i| {
            if self.all[i as usize].clarity != Clarity::None {
                met.push(i);
            }
            ray.t_max
        });
        met.sort_unstable();
        let (mut passed, mut depth) = (1.0, Rgb::BLACK);
        for i in met {
            self.all[i as usize].clear(ray, finishes, &mut passed, &mut depth);
        }
        (passed, depth)
    }
}

impl Body {
    fn bounds(&self) -> Bounds {
        match &self.kind {
            Kind::Solid(made) => made.compound.bounds(),
            Kind::Sheet(sheet) => {
                let (base, within) = (sheet.base.bounds(), sheet.within.bounds());
                Bounds { min: base.min.max(within.min), max: base.max.min(within.max) }
            }
        }
    }

    fn closest(&self, ray: &Ray) -> Option<(f64, Place)> {
        match &self.kind {
            Kind::Solid(made) => {
                let end = made.compound.closest(ray)?;
                end.wall.map(|face| (end.t, Place::Face(face)))
            }
            Kind::Sheet(sheet) => sheet.closest(ray).map(|hit| (hit.t, Place::Sheet(hit))),
        }
    }

    fn any(&self, ray: &Ray) -> bool {
        match &self.kind {
            Kind::Solid(made) => made.compound.any(ray),
            Kind::Sheet(sheet) => sheet.closest(ray).is_some(),
        }
    }

    fn finish_at(&self, place: &Place, point: Vec3) -> u32 {
        match (&self.kind, place) {
            (Kind::Solid(made), Place::Face(face)) => {
                made.finish_at(face, point).unwrap_or(self.finish)
            }
            _ => self.finish,
        }
    }

    fn blocks(&self, ray: &Ray, finishes: &[Finish]) -> bool {
        match (self.clarity, &self.kind) {
            (Clarity::All, _) => false,
            (Clarity::None, _) => self.any(ray),
            (Clarity::Some, Kind::Sheet(_)) => false,
            (Clarity::Some, Kind::Solid(made)) => made.spans(ray).iter().any(|span| {
                [span.enter, span.exit].iter().any(|end| {
                    end.wall.is_some_and(|face| {
                        let finish = self.finish_at(&Place::Face(face), ray.at(end.t));
                        !finishes[finish as usize].is_clear()
                    })
                })
            }),
        }
    }

    /// See [`Bodies::clear`]. Seen from the air on both sides: straight through a pane, that is the truth.
    fn clear(&self, ray: &Ray, finishes: &[Finish], passed: &mut f64, depth: &mut Rgb) {
        let reflectance = |normal: Vec3, ior: f64| {
            fresnel::from_air(normal.dot(ray.direction).abs().min(1.0), ior)
        };
        match &self.kind {
            Kind::Sheet(sheet) => {
                let Finish::Glass { ior, .. } = finishes[self.finish as usize] else { return };
                for hit in sheet.hits(ray) {
                    let normal = sheet.interaction(ray, &hit).normal;
                    *passed *= 1.0 - fresnel::sheet(reflectance(normal, ior));
                }
            }
            Kind::Solid(made) => {
                for span in made.spans(ray) {
                    let mut inside = None;
                    for end in [span.exit, span.enter] {
                        let Some(face) = end.wall else { continue };
                        let finish = self.finish_at(&Place::Face(face), ray.at(end.t));
                        let Finish::Glass { absorption, ior } = finishes[finish as usize] else {
                            continue;
                        };
                        let normal = made.compound.interaction(ray, &face).normal;
                        *passed *= 1.0 - reflectance(normal, ior);
                        inside = Some(absorption);
                    }
                    if let Some(absorption) = inside {
                        *depth += absorption * span.length();
                    }
                }
            }
        }
    }
}

impl Made {
    fn spans(&self, ray: &Ray) -> Vec<Span<Face>> {
        let mut spans = Vec::new();
        self.compound.spans(ray, &mut spans);
        spans
    }

    /// The finish of the primitive that the face belongs to, or of the first that holds the place.
    fn finish_at(&self, face: &Face, point: Vec3) -> Option<u32> {
        self.finishes[face.leaf()].or_else(|| {
            let holds = |leaf: &&u32| self.compound.leaf_contains(**leaf as usize, point);
            let lender = self.lenders.iter().find(holds).or(self.lenders.first());
            lender.and_then(|leaf| self.finishes[*leaf as usize])
        })
    }
}

impl Sheet {
    /// The first hit in the ray's range that lies within the region.
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let first = match &self.base {
            Base::Turned(instance) => instance.closest(ray),
            Base::Simple(shape) => shape.closest(ray),
        }?;
        if self.within.contains(ray.at(first.t)) {
            return Some(first);
        }
        let behind = first.t.next_up();
        self.hits(&ray.with_range(behind, ray.t_max)).first().copied()
    }

    /// All hits in the ray's range that lie within the region, in order. Within rounding of its edge a
    /// hit may count or not.
    fn hits(&self, ray: &Ray) -> Vec<Hit> {
        let mut hits = Vec::new();
        match &self.base {
            Base::Turned(instance) => instance.all(ray, &mut hits),
            Base::Simple(shape) => shape.all(ray, &mut hits),
        }
        if hits.is_empty() {
            return hits;
        }
        let mut within = Vec::new();
        self.within.spans(&Ray::line(ray.origin, ray.direction), &mut within);
        hits.retain(|hit| within.iter().any(|s| s.enter.t <= hit.t && hit.t <= s.exit.t));
        hits
    }

    fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        match &self.base {
            Base::Turned(instance) => instance.interaction(ray, hit),
            Base::Simple(shape) => shape.interaction(ray, hit),
        }
    }
}

impl Base {
    fn bounds(&self) -> Bounds {
        match self {
            Self::Turned(instance) => instance.bounds(),
            Self::Simple(shape) => shape.bounds(),
        }
    }
}

/// What the section leaves of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Left {
    All,
    Nothing,
    /// Perhaps a part.
    Part,
}

/// The planes that cut an object, and the finishes of their faces.
#[derive(Clone, Debug)]
pub(crate) struct Knife<'a> {
    planes: &'a [Section],
    /// The finish that the object itself wants for its cut faces.
    own: Option<u32>,
}

impl<'a> Knife<'a> {
    /// `None` if there are no planes.
    pub(crate) fn new(planes: &'a [Section], own: Option<u32>) -> Option<Self> {
        (!planes.is_empty()).then_some(Self { planes, own })
    }

    /// What is left of something within a box. What lies in front of all planes is taken away.
    pub(crate) fn of(&self, bounds: &Bounds) -> Left {
        let mut in_front = true;
        for Section { point, normal, .. } in self.planes {
            // The least and the greatest height of a corner above the plane.
            let (mut low, mut high) = (0.0, 0.0);
            for i in 0..3 {
                let ends = [bounds.min[i] - point[i], bounds.max[i] - point[i]];
                let [a, b] = ends.map(|x| if normal[i] == 0.0 { 0.0 } else { x * normal[i] });
                low += a.min(b);
                high += a.max(b);
            }
            let reach = bounds.min.abs().max(bounds.max.abs()).max_abs() + point.max_abs();
            let rounding = rondure::numeric::gamma(16) * reach;
            if high < -rounding {
                return Left::All;
            }
            in_front &= low > rounding;
        }
        if in_front { Left::Nothing } else { Left::Part }
    }

    /// The region that is left.
    fn region(&self) -> Csg {
        let behind = |s: &Section| Csg::half_space(s.point, s.normal);
        match self.planes {
            [only] => behind(only),
            several => Csg::Union(several.iter().map(behind).collect()),
        }
    }

    fn finishes(&self) -> impl Iterator<Item = Option<u32>> {
        self.planes.iter().map(|s| self.own.or(s.material.map(|m| m as u32)))
    }
}

/// Gathers bodies.
#[derive(Default)]
pub(crate) struct Builder {
    all: Vec<Body>,
    /// The solids of surfaces that are known.
    solids: HashMap<*const Surface, Arc<Solid>>,
}

impl Builder {
    /// How many bodies there are so far.
    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    /// The solid that a surface bounds, if it does.
    pub(crate) fn solid(&mut self, surface: &Arc<Surface>) -> Option<Arc<Solid>> {
        if let Some(known) = self.solids.get(&Arc::as_ptr(surface)) {
            return Some(Arc::clone(known));
        }
        let solid =
            Solid::from_surface(Arc::clone(surface), FillRule::NonZero).ok().map(Arc::new)?;
        self.solids.insert(Arc::as_ptr(surface), Arc::clone(&solid));
        Some(solid)
    }

    /// Adds a solid, cut if there is a knife. `finishes` are those of its primitives that have their own.
    pub(crate) fn add_solid(
        &mut self,
        csg: Csg,
        mut finishes: Vec<Option<u32>>,
        finish: u32,
        knife: Option<&Knife<'_>>,
    ) -> Result<(), CsgError> {
        let mut compound = csg.build()?;
        finishes.resize(compound.leaf_count(), None);
        let mut lenders = Vec::new();
        collect_lenders(&csg, false, &mut 0, &mut |leaf| {
            if finishes[leaf as usize].is_some() {
                lenders.push(leaf);
            }
        });
        if let Some(knife) = knife {
            match knife.of(&compound.bounds()) {
                Left::All => {}
                Left::Nothing => return Ok(()),
                Left::Part => {
                    finishes.extend(knife.finishes());
                    compound = csg.intersection(knife.region()).build()?;
                }
            }
        }
        let kind = Kind::Solid(Box::new(Made { compound, finishes, lenders }));
        self.all.push(Body { kind, finish, clarity: Clarity::None });
        Ok(())
    }

    /// Adds a turned surface: a part of its turn, or what a knife leaves of it, or both.
    pub(crate) fn add_turned_sheet(
        &mut self,
        instance: Instance,
        sweep: Option<&Sweep>,
        finish: u32,
        knife: Option<&Knife<'_>>,
    ) -> Result<(), CsgError> {
        let placement: &Affine = instance.placement();
        let wedge = sweep.and_then(Sweep::wedge).map(|wedge| wedge.placed(placement));
        self.add_sheet(Base::Turned(instance), wedge, finish, knife)
    }

    /// Adds what a knife leaves of a simple shape.
    pub(crate) fn add_simple_sheet(
        &mut self,
        shape: Shape,
        finish: u32,
        knife: &Knife<'_>,
    ) -> Result<(), CsgError> {
        self.add_sheet(Base::Simple(shape), None, finish, Some(knife))
    }

    fn add_sheet(
        &mut self,
        base: Base,
        region: Option<Csg>,
        finish: u32,
        knife: Option<&Knife<'_>>,
    ) -> Result<(), CsgError> {
        let regions = region.into_iter().chain(knife.map(Knife::region)).collect();
        let within = Csg::Intersection(regions).build()?;
        let kind = Kind::Sheet(Box::new(Sheet { base, within }));
        self.all.push(Body { kind, finish, clarity: Clarity::None });
        Ok(())
    }

    /// `None` if there are no bodies.
    pub(crate) fn build(mut self, finishes: &[Finish]) -> Result<Option<Bodies>, TooManyItems> {
        for body in &mut self.all {
            let own = match &body.kind {
                Kind::Solid(made) => made.finishes.as_slice(),
                Kind::Sheet(_) => &[None],
            };
            let clear = |f: &Option<u32>| finishes[f.unwrap_or(body.finish) as usize].is_clear();
            let count = own.iter().filter(|f| clear(f)).count();
            body.clarity = match count {
                0 => Clarity::None,
                n if n == own.len() => Clarity::All,
                _ => Clarity::Some,
            };
        }
        if self.all.is_empty() {
            return Ok(None);
        }
        let tree = Bvh::new(self.all.len(), |i| self.all[i as usize].bounds())?;
        Ok(Some(Bodies { all: self.all, tree }))
    }
}

/// Reports the primitives that are not taken away; `next` counts all of them.
fn collect_lenders(csg: &Csg, taken: bool, next: &mut u32, report: &mut impl FnMut(u32)) {
    match csg {
        Csg::Primitive(..) => {
            if !taken {
                report(*next);
            }
            *next += 1;
        }
        Csg::Union(all) | Csg::Intersection(all) => {
            all.iter().for_each(|operand| collect_lenders(operand, taken, next, report));
        }
        Csg::Difference(all) => {
            for (i, operand) in all.iter().enumerate() {
                collect_lenders(operand, taken || i > 0, next, report);
            }
        }
    }
}
