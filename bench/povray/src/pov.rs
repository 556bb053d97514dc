//! A scene in POV-Ray's language.
//!
//! What is the same: the camera, the curves of the profiles, flat shapes and spheres, diffuse
//! reflection, Fresnel reflection and refraction, absorption, and the fall-off of light. What can
//! only be alike: highlights, a power of a cosine whose peak and curvature are those of Rondure's.
//!
//! POV-Ray turns a lathe round y; a matrix carries y to the axis of the placed object. It mirrors,
//! which a surface of revolution does not show.

use std::{
    collections::HashMap,
    f64::consts::PI,
    fmt::{self, Display, Formatter, Write},
    sync::Arc,
};

use rondure::{Affine, Instance, Surface, Vec3};
use rondure_scene::{Camera, Color, Glass, Light, Material, Paint, Projection, Scene, Shape};

use crate::lathe::cubics;

/// The width alpha of Rondure's narrowest highlight (GGX), which lights without a body have.
const HIGHLIGHT_ALPHA: f64 = 0.02;
/// The index of refraction of the coat of glossy things.
const COAT_INDEX: f64 = 1.5;
/// The weight below which paths end: the one from which on Rondure ends them at random.
const LEAST_WEIGHT: f64 = 0.01;
/// POV-Ray's light falls off as 2 / (1 + (d / f)^2): as 1 / d^2 to a millionth from the distance
/// 1000 f on. This is f as a part of the distance from the light to the middle of the picture.
const FADE_DISTANCE: f64 = 1e-4;

struct Vector(Vec3);

impl Display for Vector {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "<{}, {}, {}>", self.0.x, self.0.y, self.0.z)
    }
}

struct Rgb(Color);

impl Display for Rgb {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "rgb <{}, {}, {}>", self.0[0], self.0[1], self.0[2])
    }
}

/// The scene for POV-Ray, and what is not the same in it.
pub(crate) fn write(scene: &Scene) -> Result<(String, Vec<String>), fmt::Error> {
    let mut pov = Pov { text: String::new(), notes: Vec::new(), lathes: HashMap::new() };
    pov.settings(scene)?;
    let aspect = f64::from(scene.film.width) / f64::from(scene.film.height);
    pov.camera(&scene.camera, aspect)?;
    for light in &scene.lights {
        pov.light(light, scene.camera.look_at, scene.film.exposure)?;
    }
    if !scene.section.is_empty() {
        pov.notes.push("POV-Ray's scene is not cut open".into());
    }
    for object in &scene.objects {
        let Some(material) = scene.materials.get(object.material) else { continue };
        writeln!(pov.text, "\n// {}", object.name.replace(char::is_control, " "))?;
        for shape in object.shapes().flatten() {
            pov.object(&object.name, &shape, material)?;
        }
    }
    Ok((pov.text, pov.notes))
}

struct Pov {
    text: String,
    notes: Vec<String>,
    /// The numbers of the lathes that stand in the text already.
    lathes: HashMap<*const Surface, usize>,
}

impl Pov {
    fn settings(&mut self, scene: &Scene) -> fmt::Result {
        writeln!(
            self.text,
            "#version 3.7;\n\
             global_settings {{ assumed_gamma 1 max_trace_level {} adc_bailout {LEAST_WEIGHT} \
             ambient_light rgb 0 }}\n\
             #default {{ finish {{ ambient 0 diffuse 1 }} }}\n\
             background {{ rgb 0 }}",
            scene.film.depth + 1
        )
    }

    fn camera(&mut self, camera: &Camera, aspect: f64) -> fmt::Result {
        let forward = (camera.look_at - camera.eye).normalized();
        let right = forward.cross(camera.up).normalized();
        let up = right.cross(forward);
        let (kind, height) = match camera.projection {
            Projection::Perspective { fov } => ("perspective", 2.0 * (0.5 * fov).tan()),
            Projection::Orthographic { height } => ("orthographic", height),
        };
        writeln!(
            self.text,
            "camera {{ {kind} location {} direction {} right {} up {} }}",
            Vector(camera.eye),
            Vector(forward),
            Vector(right * (height * aspect)),
            Vector(up * height)
        )
    }

    /// POV-Ray leaves out the 1 / pi of diffuse reflection.
    fn light(&mut self, light: &Light, look_at: Vec3, exposure: f64) -> fmt::Result {
        match *light {
            Light::Point { position, intensity } => {
                let fade = FADE_DISTANCE * (look_at - position).length();
                let color = intensity.map(|c| c * exposure / (PI * 2.0 * fade * fade));
                writeln!(
                    self.text,
                    "light_source {{ {} {} fade_power 2 fade_distance {fade} }}",
                    Vector(position),
                    Rgb(color)
                )
            }
            Light::Sun { direction, irradiance, .. } => {
                let color = irradiance.map(|c| c * exposure / PI);
                // Far enough to stand outside of any scene, near enough for POV-Ray's tolerances.
                let from = look_at + direction * 1e4;
                writeln!(
                    self.text,
                    "light_source {{ {} {} parallel point_at {} }}",
                    Vector(from),
                    Rgb(color),
                    Vector(look_at)
                )
            }
            Light::Disk { .. } | Light::Sphere { .. } => {
                self.notes.push("lights with area are left out of POV-Ray's scene".into());
                Ok(())
            }
        }
    }

    fn object(&mut self, name: &str, shape: &Shape, material: &Material) -> fmt::Result {
        let mut checker_frame = None;
        match *shape {
            Shape::Turned(ref instance) => {
                let number = self.lathe(instance)?;
                write!(self.text, "object {{ Lathe{number} ")?;
                self.matrix(&lathe_placement(instance.placement()))?;
            }
            Shape::Plane { point, normal } => {
                let (x, y) = normal.orthonormal_basis();
                checker_frame = Some((point, [x, y]));
                let distance = normal.dot(point);
                write!(self.text, "plane {{ {}, {distance}", Vector(normal))?;
            }
            Shape::Disk { center, normal, radius } => {
                let (x, y) = normal.orthonormal_basis();
                checker_frame = Some((center, [x, y]));
                write!(self.text, "disc {{ {}, {}, {radius}", Vector(center), Vector(normal))?;
            }
            Shape::Rectangle { center, edges } => {
                checker_frame = Some((center, edges.map(Vec3::normalized)));
                let corner = |a: f64, b: f64| Vector(center + edges[0] * a + edges[1] * b);
                write!(
                    self.text,
                    "polygon {{ 5, {}, {}, {}, {}, {}",
                    corner(-0.5, -0.5),
                    corner(0.5, -0.5),
                    corner(0.5, 0.5),
                    corner(-0.5, 0.5),
                    corner(-0.5, -0.5)
                )?;
            }
            Shape::Sphere { center, radius } => {
                write!(self.text, "sphere {{ {}, {radius}", Vector(center))?;
            }
            Shape::Swept { .. } | Shape::Body(_) => {
                self.notes.push(format!("{name}: left out of POV-Ray's scene, as no whole turn"));
                return Ok(());
            }
        }
        self.material(name, material, checker_frame)?;
        writeln!(self.text, " }}")
    }

    /// The number of the lathe of a placed surface, declared if it has not been.
    fn lathe(&mut self, instance: &Instance) -> Result<usize, fmt::Error> {
        let next = self.lathes.len();
        let surface = instance.surface();
        let number = *self.lathes.entry(Arc::as_ptr(surface)).or_insert(next);
        if number == next {
            let cubics = cubics(surface.profile());
            writeln!(self.text, "#declare Lathe{number} = lathe {{ bezier_spline {}", {
                4 * cubics.len()
            })?;
            for c in &cubics {
                let points = [c.p0, c.p1, c.p2, c.p3].map(|p| format!(", <{}, {}>", p.x, p.y));
                writeln!(self.text, "  {}", points.concat())?;
            }
            writeln!(self.text, "}}")?;
        }
        Ok(number)
    }

    fn matrix(&mut self, map: &Affine) -> fmt::Result {
        let [x, y, z] = map.columns;
        let rows = [x, y, z, map.translation];
        let numbers: Vec<_> =
            rows.iter().flat_map(|v| [v.x, v.y, v.z]).map(|n| n.to_string()).collect();
        write!(self.text, "matrix <{}>", numbers.join(", "))
    }

    fn material(
        &mut self,
        name: &str,
        material: &Material,
        frame: Option<(Vec3, [Vec3; 2])>,
    ) -> fmt::Result {
        let specular = |reflectance: f64| {
            let peak = 0.25 * reflectance / HIGHLIGHT_ALPHA.powi(2);
            let roughness = 0.25 * HIGHLIGHT_ALPHA.powi(2);
            format!("specular {peak} roughness {roughness}")
        };
        let fresnel = |ior: f64| ((ior - 1.0) / (ior + 1.0)).powi(2);
        match material {
            Material::Matte { color } => self.pigment(name, color, frame),
            Material::Glossy { color, specular: strength, .. } => {
                self.pigment(name, color, frame)?;
                write!(
                    self.text,
                    " finish {{ {} reflection {{ 0, {strength} fresnel on }} }} \
                     interior {{ ior {COAT_INDEX} }}",
                    specular(strength * fresnel(COAT_INDEX))
                )
            }
            Material::Mirror { color } => {
                let color = mean(color);
                write!(
                    self.text,
                    " pigment {{ rgb 0 }} finish {{ diffuse 0 {} reflection {{ {} }} }}",
                    specular(color.iter().sum::<f64>() / 3.0),
                    Rgb(color)
                )
            }
            Material::Glass(Glass { color, ior, .. }) => {
                write!(
                    self.text,
                    " pigment {{ rgbt <1, 1, 1, 1> }} finish {{ diffuse 0 {} reflection {{ 0, 1 \
                     fresnel on }} conserve_energy }} interior {{ ior {ior}",
                    specular(fresnel(*ior))
                )?;
                // Per fade_distance, exp(-(1 - fade_color)) is left.
                let absorption = color.map(|c| -c.clamp(1e-9, 1.0).ln());
                let most = absorption.iter().fold(0.0_f64, |a, &b| a.max(b));
                if most > 0.0 {
                    let fade = Rgb(absorption.map(|a| 1.0 - a / most));
                    let distance = 1.0 / most;
                    write!(
                        self.text,
                        " fade_power 1001 fade_distance {distance} fade_color {fade}"
                    )?;
                }
                write!(self.text, " }}")
            }
            Material::Metal { .. } | Material::Principled(_) => {
                self.notes
                    .push(format!("{name}: POV-Ray has no such material, and shows it black"));
                write!(self.text, " pigment {{ rgb 0 }}")
            }
        }
    }

    fn pigment(
        &mut self,
        name: &str,
        paint: &Paint,
        frame: Option<(Vec3, [Vec3; 2])>,
    ) -> fmt::Result {
        let (Paint::Checker { colors, size }, Some((center, [x, y]))) = (paint, frame) else {
            match paint {
                Paint::Solid(_) => {}
                Paint::Checker { .. } => {
                    self.notes.push(format!("{name}: the checker has its mean colour for POV-Ray"));
                }
                _ => self.notes.push(format!("{name}: the paint is grey for POV-Ray")),
            }
            return write!(self.text, " pigment {{ {} }}", Rgb(mean(paint)));
        };
        // POV-Ray's checker has cubes; the surface lies in the middle of one layer.
        let normal = x.cross(y).normalized();
        let map = Affine {
            columns: [x * size[0], y * size[1], normal],
            translation: center - normal * 0.5,
        };
        write!(self.text, " pigment {{ checker {} {} ", Rgb(colors[0]), Rgb(colors[1]))?;
        self.matrix(&map)?;
        write!(self.text, " }}")
    }
}

/// Where a lathe round y stands whose surface, round z, is placed by `map`.
fn lathe_placement(map: &Affine) -> Affine {
    let [x, y, z] = map.columns;
    Affine { columns: [x, z, y], translation: map.translation }
}

fn mean(paint: &Paint) -> Color {
    match *paint {
        Paint::Solid(color) => color,
        Paint::Checker { colors: [a, b], .. } => [0, 1, 2].map(|i| 0.5 * (a[i] + b[i])),
        _ => [0.5; 3],
    }
}
