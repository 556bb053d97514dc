//! The picture of the race: speed against the error of the mesh, one panel for each kind of rays.
//!
//! Each engine is a line through the geometric means over the shapes, in a band from the slowest to
//! the fastest shape. Rondure has no error: it stands in a column of its own, at 0, and a thin line
//! carries its speed over to Embree's.

use std::fmt::Write as _;

use super::shape::ShapeResult;

/// The panels: the name of a set of rays, and what is written over it.
const PANELS: [[&str; 2]; 6] = [
    ["camera", "camera rays"],
    ["random", "random rays"],
    ["secondary", "rays off the surface"],
    ["camera, batch", "camera rays, in batches"],
    ["random, batch", "random rays, in batches"],
    ["shadow, batch", "shadow rays, in batches"],
];

const COLUMNS: usize = 3;
const PANEL: [f64; 2] = [270.0, 230.0];
const GAP: [f64; 2] = [24.0, 62.0];
/// Left of, and above, the panels.
const MARGIN: [f64; 2] = [68.0, 84.0];
/// Right of, and below, the panels.
const REST: [f64; 2] = [20.0, 64.0];
/// How wide the column of error 0 is.
const EXACT: f64 = 52.0;

const EMBREE: &str = "#d9601a";
const RONDURE: &str = "#1f5fbf";

/// What the shapes have in common: the slowest, the geometric mean, and the fastest.
#[derive(Clone, Copy, Debug)]
struct Rates {
    least: f64,
    mean: f64,
    greatest: f64,
}

impl Rates {
    fn of(rates: &[f64]) -> Option<Self> {
        let logs = rates.iter().map(|rate| rate.ln()).sum::<f64>() / rates.len() as f64;
        let fold = |f: fn(f64, f64) -> f64| rates.iter().copied().reduce(f);
        Some(Self { least: fold(f64::min)?, mean: logs.exp(), greatest: fold(f64::max)? })
    }
}

/// One panel's data.
#[derive(Clone, Debug)]
struct Panel {
    title: &'static str,
    /// By error, coarse to fine.
    embree: Vec<(f64, Rates)>,
    rondure: Option<Rates>,
}

fn panel(shapes: &[ShapeResult], [set, title]: [&'static str; 2]) -> Panel {
    let place = |shape: &ShapeResult| shape.sets.iter().position(|info| info.name == set);
    let mut errors: Vec<f64> =
        shapes.iter().flat_map(|shape| &shape.errors).map(|error| error.error).collect();
    errors.sort_by(|a, b| b.total_cmp(a));
    errors.dedup();
    let embree = errors.into_iter().filter_map(|error| {
        let rate = |shape: &ShapeResult| {
            let result = shape.errors.iter().find(|result| result.error == error)?;
            Some(result.best(place(shape)?)?.rate)
        };
        let rates: Vec<_> = shapes.iter().filter_map(rate).collect();
        Some((error, Rates::of(&rates)?))
    });
    let own = shapes.iter().filter_map(|shape| Some(shape.rondure(place(shape)?)?.median()));
    Panel { title, embree: embree.collect(), rondure: Rates::of(&own.collect::<Vec<_>>()) }
}

/// A logarithmic scale from two numbers to two coordinates.
#[derive(Clone, Copy, Debug)]
struct Scale {
    from: [f64; 2],
    to: [f64; 2],
}

impl Scale {
    fn at(&self, x: f64) -> f64 {
        let part = (x / self.from[0]).ln() / (self.from[1] / self.from[0]).ln();
        self.to[0] + part * (self.to[1] - self.to[0])
    }
}

/// The picture, as SVG.
pub(crate) fn plot(shapes: &[ShapeResult]) -> String {
    let panels: Vec<_> = PANELS.into_iter().map(|names| panel(shapes, names)).collect();
    let rows = panels.len().div_ceil(COLUMNS);
    let size = |axis: usize, count: usize| {
        let count = count as f64;
        MARGIN[axis] + count * PANEL[axis] + (count - 1.0) * GAP[axis] + REST[axis]
    };
    let (width, height) = (size(0, COLUMNS), size(1, rows));
    let mut svg = Svg(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"#222\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    ));
    let (low, high) = decades(&panels);
    for (i, panel) in panels.iter().enumerate() {
        let column = (i % COLUMNS) as f64;
        let row = (i / COLUMNS) as f64;
        let x = MARGIN[0] + column * (PANEL[0] + GAP[0]);
        let y = MARGIN[1] + row * (PANEL[1] + GAP[1]);
        svg.panel(panel, [x, y], [low, high], i % COLUMNS == 0);
    }
    svg.legend(shapes);
    svg.text(
        [MARGIN[0] + 0.5 * (width - MARGIN[0] - REST[0]), height - 14.0],
        "text-anchor=\"middle\"",
        "error of the surface, as a fraction of its height",
    );
    let middle = MARGIN[1] + 0.5 * (height - MARGIN[1] - REST[1]);
    svg.text(
        [0.0, 0.0],
        &format!("text-anchor=\"middle\" transform=\"translate(13 {middle}) rotate(-90)\""),
        "million rays a second, one thread",
    );
    svg.0.push_str("</svg>\n");
    svg.0
}

/// The powers of ten round all that is drawn.
fn decades(panels: &[Panel]) -> (f64, f64) {
    let embree = panels.iter().flat_map(|panel| panel.embree.iter().map(|(_, rates)| *rates));
    let all = embree.chain(panels.iter().filter_map(|panel| panel.rondure));
    let (low, high) = all.fold((f64::INFINITY, 0.0_f64), |(low, high), rates| {
        (low.min(rates.least), high.max(rates.greatest))
    });
    if low > high {
        return (1e6, 1e8);
    }
    (10_f64.powf(low.log10().floor()), 10_f64.powf(high.log10().ceil()))
}

/// A drawing that grows.
struct Svg(String);

impl Svg {
    fn add(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{element}");
    }

    fn text(&mut self, [x, y]: [f64; 2], style: &str, text: &str) {
        self.add(format_args!("<text x=\"{x:.1}\" y=\"{y:.1}\" {style}>{text}</text>"));
    }

    fn line(&mut self, [a, b]: [[f64; 2]; 2], style: &str) {
        let ([x, y], [to_x, to_y]) = (a, b);
        self.add(format_args!("<path d=\"M{x:.1} {y:.1}L{to_x:.1} {to_y:.1}\" {style}/>"));
    }

    fn path(&mut self, points: impl IntoIterator<Item = [f64; 2]>, close: &str, style: &str) {
        let mut d = String::new();
        for [x, y] in points {
            let _ = write!(d, "{}{x:.1} {y:.1}", if d.is_empty() { 'M' } else { 'L' });
        }
        self.add(format_args!("<path d=\"{d}{close}\" {style}/>"));
    }

    fn dot(&mut self, [x, y]: [f64; 2], color: &str) {
        self.add(format_args!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{color}\"/>"));
    }

    fn panel(&mut self, panel: &Panel, [x, y]: [f64; 2], range: [f64; 2], labels: bool) {
        let [width, height] = PANEL;
        let speed = Scale { from: range, to: [y + height, y] };
        let coarse = panel.embree.first().map_or(1e-3, |(error, _)| *error);
        let fine = panel.embree.last().map_or(1e-6, |(error, _)| *error);
        // With one error only, it stands in the middle.
        let fine = if fine < coarse { fine } else { 0.1 * coarse };
        let errors = Scale { from: [coarse, fine], to: [x + 26.0, x + width - EXACT - 26.0] };
        let exact = x + width - 0.5 * EXACT;

        self.text([x, y - 10.0], "font-weight=\"bold\"", panel.title);
        self.grid(x, y, range, &speed, labels);
        for (error, _) in &panel.embree {
            let at = errors.at(*error);
            self.text([at, y + height + 18.0], "text-anchor=\"middle\"", &power(*error));
        }
        self.text([exact, y + height + 18.0], "text-anchor=\"middle\"", "0");

        let points = |of: fn(&Rates) -> f64| {
            let place =
                move |(error, rates): &(f64, Rates)| [errors.at(*error), speed.at(of(rates))];
            panel.embree.iter().map(place).collect::<Vec<_>>()
        };
        let band = points(|r| r.least).into_iter().chain(points(|r| r.greatest).into_iter().rev());
        self.path(band, "Z", &format!("fill=\"{EMBREE}\" fill-opacity=\"0.18\""));
        let style = format!("fill=\"none\" stroke=\"{EMBREE}\" stroke-width=\"2.2\"");
        self.path(points(|r| r.mean), "", &style);
        for point in points(|r| r.mean) {
            self.dot(point, EMBREE);
        }
        if let Some(own) = panel.rondure {
            let [low, high, mean] = [own.least, own.greatest, own.mean].map(|rate| speed.at(rate));
            self.add(format_args!(
                "<rect x=\"{:.1}\" y=\"{high:.1}\" width=\"16\" height=\"{:.1}\" fill=\"{RONDURE}\" \
                 fill-opacity=\"0.25\"/>",
                exact - 8.0,
                low - high,
            ));
            let style =
                format!("stroke=\"{RONDURE}\" stroke-width=\"1.6\" stroke-dasharray=\"5 4\"");
            self.line([[x, mean], [exact, mean]], &style);
            self.dot([exact, mean], RONDURE);
        }
    }

    /// The frame, a line for each power of ten, thin ones for 2 and 5, and the column of error 0.
    fn grid(&mut self, x: f64, y: f64, range: [f64; 2], speed: &Scale, labels: bool) {
        let [width, height] = PANEL;
        self.add(format_args!(
            "<rect x=\"{:.1}\" y=\"{y:.1}\" width=\"{EXACT}\" height=\"{height}\" fill=\"#eef3fb\"/>",
            x + width - EXACT,
        ));
        let mut decade = range[0];
        while decade < range[1] * 1.01 {
            for factor in [1.0, 2.0, 5.0] {
                let rate = decade * factor;
                if rate > range[1] * 1.01 {
                    break;
                }
                let at = speed.at(rate);
                let color = if factor == 1.0 { "#bbb" } else { "#e4e4e4" };
                self.line([[x, at], [x + width, at]], &format!("stroke=\"{color}\""));
                if labels {
                    let label = format!("{}", rate * 1e-6);
                    self.text([x - 8.0, at + 4.5], "text-anchor=\"end\"", &label);
                }
            }
            decade *= 10.0;
        }
        self.add(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width}\" height=\"{height}\" fill=\"none\" \
             stroke=\"#888\"/>"
        ));
    }

    fn legend(&mut self, shapes: &[ShapeResult]) {
        let names: Vec<_> = shapes.iter().map(|shape| shape.name.as_str()).collect();
        let (x, y) = (MARGIN[0], 24.0);
        self.dot([x + 14.0, y - 4.5], RONDURE);
        let style = format!("stroke=\"{RONDURE}\" stroke-width=\"1.6\" stroke-dasharray=\"5 4\"");
        self.line([[x, y - 4.5], [x + 28.0, y - 4.5]], &style);
        self.text([x + 36.0, y], "", "Rondure: the curve itself, in f64");
        let x = x + 260.0;
        self.dot([x + 14.0, y - 4.5], EMBREE);
        let style = format!("stroke=\"{EMBREE}\" stroke-width=\"2.2\"");
        self.line([[x, y - 4.5], [x + 28.0, y - 4.5]], &style);
        self.text(
            [x + 36.0, y],
            "",
            "Embree 4.4: the fastest of triangles, quads and grids, in f32",
        );
        let what = format!(
            "Lines and dots: mean of {}; shaded: from the slowest to the fastest.",
            names.join(", ")
        );
        self.text([MARGIN[0], y + 22.0], "fill=\"#666\" font-size=\"12\"", &what);
    }
}

/// A power of ten as one writes it.
fn power(x: f64) -> String {
    let exponent = x.log10().round();
    let factor = x / 10_f64.powf(exponent);
    let power = format!(
        "10<tspan dy=\"-5\" font-size=\"10\">{}</tspan>",
        exponent.to_string().replace('-', "−")
    );
    if (factor - 1.0).abs() < 1e-9 { power } else { format!("{x:e}") }
}
