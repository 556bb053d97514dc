//! Text from files, with an error for everything that a path can turn out to be.

use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

use crate::{Diagnostic, Report};

/// The size of the largest text file that is read, in bytes: 64 MiB. A scene or a profile beyond that is
/// a mistake in the name.
pub const LARGEST_FILE: u64 = 64 << 20;

/// The bytes of a file, if there are no more than `largest`.
pub(crate) fn read_bytes(path: &Path, largest: u64) -> Result<Vec<u8>, Report> {
    let name = path.display();
    let unreadable = |e: io::Error| {
        let help = match e.kind() {
            io::ErrorKind::NotFound => "check the name and the folder",
            io::ErrorKind::PermissionDenied => "check the file's permissions",
            _ => "check the name, and the disk or the device that it is on",
        };
        Report::only(Diagnostic::error(format!("cannot read `{name}`: {}", plain(&e))).help(help))
    };
    let file = File::open(path).map_err(unreadable)?;
    if file.metadata().map_err(unreadable)?.is_dir() {
        let error = Diagnostic::error(format!("cannot read `{name}`: it is a directory"));
        return Err(Report::only(error.help("give the name of a file in it")));
    }
    let mut bytes = Vec::new();
    file.take(largest + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > largest {
        let limit = largest >> 20;
        let message = format!("cannot read `{name}`: it is larger than {limit} MiB");
        return Err(Report::only(Diagnostic::error(message)));
    }
    Ok(bytes)
}

pub(crate) fn read_text(path: &Path) -> Result<String, Report> {
    let name = path.display();
    let bytes = read_bytes(path, LARGEST_FILE)?;
    let mut text = String::from_utf8(bytes).map_err(|e| {
        let good = e.utf8_error().valid_up_to();
        let bytes = e.as_bytes();
        let line = 1 + bytes[..good].iter().filter(|b| **b == b'\n').count();
        let byte = bytes[good];
        let message = format!(
            "cannot read `{name}`: it is not UTF-8 text: byte {good} (0x{byte:02x}, in line {line}) \
             begins no character"
        );
        let utf16 = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
        let diagnostic = Diagnostic::error(message);
        Report::only(if utf16 {
            diagnostic.help("it looks like UTF-16; save it as UTF-8")
        } else {
            diagnostic
        })
    })?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

/// The message of the operating system without its number.
fn plain(error: &io::Error) -> String {
    let text = error.to_string();
    match text.find(" (os error ") {
        Some(end) => text[..end].to_lowercase(),
        None => text,
    }
}
