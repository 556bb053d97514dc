//! A drawing in SVG, point by point.

use std::fmt::{Display, Write as _};

/// A drawing that grows.
pub(crate) struct Svg {
    text: String,
}

/// A point of the drawing, x to the right and y down.
pub(crate) type P = [f64; 2];

impl Svg {
    pub(crate) fn new(width: f64, height: f64) -> Self {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             width=\"{width}\" height=\"{height}\" font-family=\"Helvetica, Arial, sans-serif\" \
             font-size=\"13\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
        );
        Self { text }
    }

    pub(crate) fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    fn add(&mut self, element: impl Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{element}");
    }

    /// A chain of lines; `style` are the attributes of its look.
    pub(crate) fn path(&mut self, points: impl IntoIterator<Item = P>, closed: bool, style: &str) {
        let mut d = String::new();
        for (i, [x, y]) in points.into_iter().enumerate() {
            let _ = write!(d, "{}{x:.2} {y:.2} ", if i == 0 { "M" } else { "L" });
        }
        let end = if closed { "Z" } else { "" };
        self.add(format_args!("<path d=\"{d}{end}\" {style}/>"));
    }

    pub(crate) fn line(&mut self, a: P, b: P, style: &str) {
        self.path([a, b], false, style);
    }

    pub(crate) fn dot(&mut self, [x, y]: P, radius: f64, style: &str) {
        self.add(format_args!("<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" {style}/>"));
    }

    pub(crate) fn rect(&mut self, [x, y]: P, [width, height]: P, style: &str) {
        self.add(format_args!(
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" {style}/>"
        ));
    }

    /// A text; `<tspan>` and entities in it are kept.
    pub(crate) fn text(&mut self, [x, y]: P, style: &str, text: impl Display) {
        self.add(format_args!("<text x=\"{x:.2}\" y=\"{y:.2}\" {style}>{text}</text>"));
    }

    /// A line with an arrow's head at its end.
    pub(crate) fn arrow(&mut self, a: P, b: P, color: &str, width: f64) {
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let (dx, dy) = ((b[0] - a[0]) / length, (b[1] - a[1]) / length);
        let size = 4.0 + 2.5 * width;
        let base = [b[0] - size * dx, b[1] - size * dy];
        self.line(a, base, &format!("fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\""));
        let half = 0.38 * size;
        let head = [
            b,
            [base[0] - half * dy, base[1] + half * dx],
            [base[0] + half * dy, base[1] - half * dx],
        ];
        self.path(head, true, &format!("fill=\"{color}\" stroke=\"none\""));
    }
}
