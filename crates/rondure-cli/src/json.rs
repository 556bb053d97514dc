//! JSON, written. Numbers read back as exactly the same f64 (RFC 8259).

use std::fmt;

/// A JSON value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Json {
    Null,
    /// One that is not finite is written as `null`: JSON has no other word for it.
    Number(f64),
    Text(String),
    List(Vec<Json>),
    Object(Vec<(&'static str, Json)>),
}

impl From<f64> for Json {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<&str> for Json {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl<T: Into<Json>> From<Option<T>> for Json {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Null, Into::into)
    }
}

impl<const N: usize> From<[f64; N]> for Json {
    fn from(numbers: [f64; N]) -> Self {
        Self::List(numbers.map(Self::Number).into())
    }
}

impl Json {
    fn write(&self, f: &mut fmt::Formatter<'_>, indent: usize) -> fmt::Result {
        match self {
            Self::Null => f.write_str("null"),
            Self::Number(x) if x.is_finite() => {
                // `-0.0` and `1.0` are numbers of JSON as they are.
                f.write_str(ryu::Buffer::new().format_finite(*x))
            }
            Self::Number(_) => f.write_str("null"),
            Self::Text(text) => quoted(text, f),
            Self::List(items) if items.iter().all(|i| matches!(i, Self::Number(_))) => {
                f.write_str("[")?;
                for (i, item) in items.iter().enumerate() {
                    f.write_str(if i == 0 { "" } else { ", " })?;
                    item.write(f, indent)?;
                }
                f.write_str("]")
            }
            Self::List(items) => {
                let lines = items.iter().map(|item| (None, item));
                block(f, ['[', ']'], lines, indent)
            }
            Self::Object(fields) => {
                let lines = fields.iter().map(|(key, value)| (Some(*key), value));
                block(f, ['{', '}'], lines, indent)
            }
        }
    }
}

fn block<'a>(
    f: &mut fmt::Formatter<'_>,
    [open, close]: [char; 2],
    lines: impl Iterator<Item = (Option<&'a str>, &'a Json)>,
    indent: usize,
) -> fmt::Result {
    let mut first = true;
    write!(f, "{open}")?;
    for (key, value) in lines {
        write!(f, "{}\n{:2$}", if first { "" } else { "," }, "", indent + 2)?;
        first = false;
        if let Some(key) = key {
            quoted(key, f)?;
            f.write_str(": ")?;
        }
        value.write(f, indent + 2)?;
    }
    if !first {
        write!(f, "\n{:1$}", "", indent)?;
    }
    write!(f, "{close}")
}

fn quoted(text: &str, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    f.write_str("\"")?;
    for c in text.chars() {
        match c {
            '"' | '\\' => write!(f, "\\{c}")?,
            '\n' => f.write_str("\\n")?,
            c if c < ' ' => write!(f, "\\u{:04x}", u32::from(c))?,
            c => write!(f, "{c}")?,
        }
    }
    f.write_str("\"")
}

impl fmt::Display for Json {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_written_as_rfc_8259_has_it() {
        let value = Json::Object(vec![
            ("text", "a \"b\" \\ \n \u{1} ü".into()),
            ("numbers", [1.0, -0.1, 5e-324, 1e300, f64::NAN].into()),
            ("nothing", Option::<f64>::None.into()),
            ("empty", Json::List(vec![])),
            ("list", Json::List(vec![Json::Object(vec![("x", 0.0.into())]), Json::Null])),
        ]);
        assert_eq!(
            value.to_string(),
            r#"{
  "text": "a \"b\" \\ \n \u0001 ü",
  "numbers": [1.0, -0.1, 5e-324, 1e300, null],
  "nothing": null,
  "empty": [],
  "list": [
    {
      "x": 0.0
    },
    null
  ]
}"#
        );
    }
}
