//! A fingerprint of a scene with all that it refers to, by which work on it is known again.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, Read},
    path::{Path, PathBuf},
};

use sha2::{Digest, Sha256};
use toml::de::{DeTable, DeValue};

/// No path is longer.
const LONGEST_PATH: usize = 4096;

/// SHA-256 of a scene file and of every file that it refers to: profiles, drawings, pictures. What counts as a reference is each text in the
/// scene that is the name of a file, looked for beside the scene; one too many does no harm.
///
/// # Errors
/// If one of these files cannot be read. A scene that is no TOML refers to nothing.
pub fn scene_digest(path: &Path) -> io::Result<[u8; 32]> {
    let mut scene = Vec::new();
    File::open(path)?.read_to_end(&mut scene)?;
    let text = String::from_utf8_lossy(&scene);
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut files = BTreeMap::new();
    let (document, _) = DeTable::parse_recoverable(&text);
    for (_, value) in document.get_ref() {
        collect(value.get_ref(), folder, &mut files);
    }
    let mut hash = Sha256::new();
    hash.update((scene.len() as u64).to_le_bytes());
    hash.update(&scene);
    for (name, file) in files {
        hash.update((name.len() as u64).to_le_bytes());
        hash.update(name.as_bytes());
        hash.update(file_digest(&file)?);
    }
    Ok(hash.finalize().into())
}

/// Finds the names of files in a value.
fn collect(value: &DeValue<'_>, folder: &Path, files: &mut BTreeMap<String, PathBuf>) {
    match value {
        DeValue::String(text) => {
            if text.is_empty() || text.len() > LONGEST_PATH || files.contains_key(&**text) {
                return;
            }
            let path = folder.join(&**text);
            if path.is_file() {
                files.insert(text.to_string(), path);
            }
        }
        DeValue::Array(items) => items.iter().for_each(|v| collect(v.get_ref(), folder, files)),
        DeValue::Table(table) => {
            table.iter().for_each(|(_, v)| collect(v.get_ref(), folder, files));
        }
        _ => {}
    }
}

fn file_digest(path: &Path) -> io::Result<[u8; 32]> {
    let mut file = File::open(path)?;
    let mut hash = Sha256::new();
    let mut block = vec![0; 1 << 16];
    loop {
        match file.read(&mut block) {
            Ok(0) => return Ok(hash.finalize().into()),
            Ok(n) => hash.update(&block[..n]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn scenes_and_their_files_count_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        let scene =
            "[profiles.a]\nfile = \"a.path\"\n[[object]]\nprofile = { file = \"sub/b.csv\" }\n";
        fs::write(at("s.toml"), scene).unwrap();
        fs::write(at("a.path"), "M 0 0 L 1 1").unwrap();
        fs::write(at("sub/b.csv"), "0,0\n1,1\n").unwrap();
        let digest = || scene_digest(&at("s.toml")).unwrap();
        let first = digest();
        fs::write(at("other.path"), "M 0 0").unwrap();
        assert_eq!(first, digest());
        for (name, text) in
            [("a.path", "M 0 0 L 1 2"), ("sub/b.csv", "0,0\n1,2\n"), ("s.toml", "x = 1")]
        {
            let old = fs::read(at(name)).unwrap();
            fs::write(at(name), text).unwrap();
            assert_ne!(first, digest(), "{name}");
            fs::write(at(name), old).unwrap();
            assert_eq!(first, digest());
        }
        fs::remove_file(at("a.path")).unwrap();
        assert_ne!(first, digest());
        assert!(scene_digest(&at("none.toml")).is_err());
        fs::write(at("s.toml"), [0xff, 0xfe, b'[']).unwrap();
        digest();
    }
}
