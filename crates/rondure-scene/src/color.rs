//! Colours in words: CSS names and hex codes, which are sRGB.

use crate::Color;

/// A colour by its CSS name or as `#rgb` or `#rrggbb`, made linear; `None` if it is neither, or not
/// opaque.
pub(crate) fn from_text(text: &str) -> Option<Color> {
    let color: svgtypes::Color = text.parse().ok()?;
    let is_code = text.starts_with('#') && matches!(text.len(), 4 | 7);
    let is_name = text.bytes().all(|b| b.is_ascii_alphabetic());
    ((is_code || is_name) && color.alpha == u8::MAX)
        .then(|| [color.red, color.green, color.blue].map(linear))
}

/// The transfer curve of sRGB (IEC 61966-2-1), from a byte to linear light.
fn linear(byte: u8) -> f64 {
    decoded(f64::from(byte) / 255.0)
}

/// The same from a signal between 0 and 1.
pub(crate) fn decoded(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// What to say about a text that is no colour.
pub(crate) fn help(text: &str) -> String {
    let near = (!text.starts_with('#')).then(|| crate::decode::nearest(text, NAMES.split(' ')));
    match near.flatten() {
        Some(near) => format!("did you mean `{near}`?"),
        None => "a colour is a CSS name such as \"tomato\", \"#rgb\" or \"#rrggbb\" (sRGB), or \
                 [r, g, b] (linear)"
            .into(),
    }
}

/// The names of CSS Color 3.
const NAMES: &str = "aliceblue antiquewhite aqua aquamarine azure beige bisque black \
    blanchedalmond blue blueviolet brown burlywood cadetblue chartreuse chocolate coral \
    cornflowerblue cornsilk crimson cyan darkblue darkcyan darkgoldenrod darkgray darkgreen \
    darkgrey darkkhaki darkmagenta darkolivegreen darkorange darkorchid darkred darksalmon \
    darkseagreen darkslateblue darkslategray darkslategrey darkturquoise darkviolet deeppink \
    deepskyblue dimgray dimgrey dodgerblue firebrick floralwhite forestgreen fuchsia gainsboro \
    ghostwhite gold goldenrod gray green greenyellow grey honeydew hotpink indianred indigo ivory \
    khaki lavender lavenderblush lawngreen lemonchiffon lightblue lightcoral lightcyan \
    lightgoldenrodyellow lightgray lightgreen lightgrey lightpink lightsalmon lightseagreen \
    lightskyblue lightslategray lightslategrey lightsteelblue lightyellow lime limegreen linen \
    magenta maroon mediumaquamarine mediumblue mediumorchid mediumpurple mediumseagreen \
    mediumslateblue mediumspringgreen mediumturquoise mediumvioletred midnightblue mintcream \
    mistyrose moccasin navajowhite navy oldlace olive olivedrab orange orangered orchid \
    palegoldenrod palegreen paleturquoise palevioletred papayawhip peachpuff peru pink plum \
    powderblue purple red rosybrown royalblue saddlebrown salmon sandybrown seagreen seashell \
    sienna silver skyblue slateblue slategray slategrey snow springgreen steelblue tan teal \
    thistle tomato turquoise violet wheat white whitesmoke yellow yellowgreen";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_codes_are_srgb() {
        for name in NAMES.split(' ') {
            assert!(from_text(name).is_some(), "{name}");
        }
        assert_eq!(from_text("#f00"), Some([1.0, 0.0, 0.0]));
        assert_eq!(from_text("#808080"), from_text("grey"));
        let grey = from_text("#808080").unwrap()[0];
        assert!((grey - 0.215_860_500_113_899_26).abs() < 1e-15, "{grey}");
    }

    #[test]
    fn what_is_no_colour() {
        for text in [
            "",
            "#",
            "#12",
            "#12345",
            "#1234567",
            "#gggggg",
            "transparent",
            "reed",
            "red ",
            "#f008",
        ] {
            assert_eq!(from_text(text), None, "{text}");
        }
        assert_eq!(help("tomatoe"), "did you mean `tomato`?");
    }
}
